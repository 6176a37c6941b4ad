//! The name server: where ports are. One connection, made again when it breaks.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs as _};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::NameError;

/// How long the name server may take to accept a connection, and to answer.
const TO_CONNECT: Duration = Duration::from_secs(1);
const TO_ANSWER: Duration = Duration::from_secs(3);

/// For how long others do not ask it then.
const AFTER_SILENCE: Duration = Duration::from_secs(2);

/// Greatest size of an answer: a list of some 100,000 ports.
const MOST_ANSWER: usize = 8 << 20;

/// Last line of an answer.
const END: &str = "*** end of message";

/// Whether a text can be a port's name everywhere: in commands, lists and messages.
pub(crate) fn is_name(text: &str) -> bool {
    let mark = |c: char| c.is_whitespace() || c.is_control() || "\"()[]{}\\".contains(c);
    text.len() > 1 && text.len() <= 255 && text.starts_with('/') && !text.contains(mark)
}

/// Where a port is, as registered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Contact {
    pub(crate) name: String,
    pub(crate) host: String,
    pub(crate) port: u16,
    /// `tcp`, or `mcast` for one that cannot be dialled.
    pub(crate) carrier: String,
}

impl Contact {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let mut wanted = |word: &str| words.find(|found| *found == word).and(words.next());
        Some(Self {
            name: wanted("name")?.to_owned(),
            host: wanted("ip")?.to_owned(),
            port: wanted("port")?.parse().ok()?,
            carrier: wanted("type")?.to_owned(),
        })
    }

    /// Its address. Looks a host's name up, which may take a while.
    pub(crate) fn address(&self) -> Option<SocketAddr> {
        (self.host.as_str(), self.port).to_socket_addrs().ok()?.next()
    }
}

/// The connection.
#[derive(Debug, Default)]
struct Line {
    stream: Option<TcpStream>,
    /// When the server did not answer. Others do not wait for it again at once.
    silent: Option<Instant>,
}

/// Asks the name server.
#[derive(Debug)]
pub(crate) struct Names {
    server: (String, u16),
    line: Mutex<Line>,
    /// Number of connections made so far: after another one, the server may know nothing.
    connections: AtomicU64,
}

impl Names {
    pub(crate) fn new(server: (String, u16)) -> Self {
        Self { server, line: Mutex::default(), connections: AtomicU64::new(0) }
    }

    pub(crate) fn server(&self) -> String {
        format!("{}:{}", self.server.0, self.server.1)
    }

    pub(crate) fn connections(&self) -> u64 {
        self.connections.load(Ordering::SeqCst)
    }

    /// The lines of the answer to a command.
    pub(crate) fn ask(&self, command: &str) -> Result<Vec<String>, NameError> {
        let mut line = self.line.lock().unwrap_or_else(PoisonError::into_inner);
        if line.silent.is_some_and(|since| since.elapsed() < AFTER_SILENCE) {
            return Err(self.silent());
        }
        let answer = self.ask_on(&mut line.stream, command);
        if answer.is_err() {
            line.stream = None;
        }
        let silent = matches!(answer, Err(NameError::Silent { .. }));
        line.silent = silent.then(Instant::now);
        answer
    }

    fn ask_on(
        &self,
        line: &mut Option<TcpStream>,
        command: &str,
    ) -> Result<Vec<String>, NameError> {
        if let Some(stream) = line {
            match self.exchange(stream, command) {
                // It ended since: a new one may be there.
                Err(NameError::Absent { .. }) => {}
                answered => return answered,
            }
        }
        let stream = line.insert(self.connect()?);
        self.exchange(stream, command)
    }

    fn silent(&self) -> NameError {
        NameError::Silent { server: self.server(), within: TO_ANSWER }
    }

    fn connect(&self) -> Result<TcpStream, NameError> {
        let absent = |why: String| NameError::Absent { server: self.server(), why };
        let (host, port) = &self.server;
        let found = (host.as_str(), *port).to_socket_addrs();
        let found = found.map_err(|error| absent(error.to_string()))?.next();
        let address = found.ok_or_else(|| absent("the host has no address".to_owned()))?;
        let connected = TcpStream::connect_timeout(&address, TO_CONNECT);
        let mut stream = connected.map_err(|error| absent(error.to_string()))?;
        let _ = stream.set_nodelay(true);
        let greeting = stream.write_all(b"CONNECT genomd\r\n");
        greeting.map_err(|error| absent(error.to_string()))?;
        let said = self.read(&mut stream, |text| text.contains('\n'))?;
        if !said.starts_with("Welcome") {
            let said = said.chars().take(60).collect();
            return Err(NameError::Foreign { server: self.server(), said });
        }
        self.connections.fetch_add(1, Ordering::SeqCst);
        Ok(stream)
    }

    fn exchange(&self, stream: &mut TcpStream, command: &str) -> Result<Vec<String>, NameError> {
        let sent = stream.write_all(format!("d\n{command}\n").as_bytes());
        let absent = |why: String| NameError::Absent { server: self.server(), why };
        sent.map_err(|error| absent(error.to_string()))?;
        let text = self.read(stream, |text| text.trim_end().ends_with(END))?;
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && *line != END);
        Ok(lines.map(str::to_owned).collect())
    }

    /// Reads until `complete`.
    fn read(
        &self,
        stream: &mut TcpStream,
        complete: impl Fn(&str) -> bool,
    ) -> Result<String, NameError> {
        let end = Instant::now() + TO_ANSWER;
        let mut answer = Vec::new();
        let mut piece = [0; 1 << 14];
        loop {
            let tail = answer.get(answer.len().saturating_sub(64)..).unwrap_or_default();
            if complete(&String::from_utf8_lossy(tail)) {
                return Ok(String::from_utf8_lossy(&answer).into_owned());
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(self.silent());
            }
            let _ = stream.set_read_timeout(Some(left));
            match stream.read(&mut piece) {
                Ok(0) => {
                    let why = "it ended the connection".to_owned();
                    return Err(NameError::Absent { server: self.server(), why });
                }
                Ok(size) => answer.extend_from_slice(piece.get(..size).unwrap_or_default()),
                Err(error) if is_timeout(&error) => {}
                Err(error) => {
                    let why = error.to_string();
                    return Err(NameError::Absent { server: self.server(), why });
                }
            }
            if answer.len() > MOST_ANSWER {
                let said = format!("more than {MOST_ANSWER} bytes");
                return Err(NameError::Foreign { server: self.server(), said });
            }
        }
    }

    /// Where a port is; `None` if no such port is registered.
    pub(crate) fn query(&self, name: &str) -> Result<Option<Contact>, NameError> {
        let lines = self.ask(&format!("query {}", checked(name)?))?;
        Ok(lines.iter().find_map(|line| Contact::parse(line)).filter(|found| found.name == name))
    }

    /// Ports whose names begin so; all for an empty prefix.
    pub(crate) fn list(&self, prefix: &str) -> Result<Vec<Contact>, NameError> {
        let lines = self.ask(&format!("list {prefix}"))?;
        Ok(lines.iter().filter_map(|line| Contact::parse(line)).collect())
    }

    /// Registers a port, in place of what was registered under its name.
    pub(crate) fn register(&self, name: &str, at: SocketAddr) -> Result<(), NameError> {
        let (ip, port) = (at.ip(), at.port());
        let lines = self.ask(&format!("register {} tcp {ip} {port}", checked(name)?))?;
        let registered = lines.iter().find_map(|line| Contact::parse(line));
        if registered.is_some_and(|found| found.name == name && found.port == port) {
            return Ok(());
        }
        let (server, name) = (self.server(), name.to_owned());
        Err(NameError::Refused { server, name, said: lines.join(" ").chars().take(200).collect() })
    }

    pub(crate) fn unregister(&self, name: &str) -> Result<(), NameError> {
        self.ask(&format!("unregister {}", checked(name)?)).map(|_| ())
    }

    /// Sets a property of a registered port; it goes when the port is unregistered.
    pub(crate) fn set(&self, name: &str, property: &str, value: &str) -> Result<(), NameError> {
        self.ask(&format!("set {} {property} {value}", checked(name)?)).map(|_| ())
    }

    /// A property of a registered port; empty if it has none.
    pub(crate) fn get(&self, name: &str, property: &str) -> Result<String, NameError> {
        let lines = self.ask(&format!("get {} {property}", checked(name)?))?;
        let value = lines.first().and_then(|line| line.split_once(" = "));
        Ok(value.map(|(_, value)| value.trim().to_owned()).unwrap_or_default())
    }

    /// Tells the name server that a port is ready, so that it makes the connections that others
    /// subscribed it to. Does not wait for that.
    pub(crate) fn announce(&self, name: &str) {
        let told = || -> std::io::Result<()> {
            let (host, port) = &self.server;
            let Some(address) = (host.as_str(), *port).to_socket_addrs()?.next() else {
                return Ok(());
            };
            let mut stream = TcpStream::connect_timeout(&address, TO_CONNECT)?;
            stream.write_all(format!("NAME_SERVER announce {name}\n").as_bytes())
        };
        if let Err(error) = told() {
            tracing::debug!(name, %error, "the YARP name server was not told that a port is ready");
        }
    }
}

fn is_timeout(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), Interrupted | TimedOut | WouldBlock)
}

fn checked(name: &str) -> Result<&str, NameError> {
    if is_name(name) { Ok(name) } else { Err(NameError::Name(name.to_owned())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_registration_is_read_from_its_line() {
        let line = "registration name /a/b ip 127.0.0.1 port 5000 type tcp";
        let contact = Contact::parse(line).unwrap();
        assert_eq!((contact.name.as_str(), contact.port), ("/a/b", 5000));
        assert_eq!(contact.address(), Some("127.0.0.1:5000".parse().unwrap()));
        assert_eq!(Contact::parse("registration name /a/b ip 127.0.0.1 port 70000 type tcp"), None);
        assert_eq!(Contact::parse("port /a/b property x = y"), None);
    }

    #[test]
    fn names_hold_nothing_that_ends_a_command() {
        for name in ["/demo/position", "/demo/poses/far.left", "/icub/cam:i", "/été/x"] {
            assert!(is_name(name), "{name}");
        }
        for name in ["", "/", "demo/x", "/a b", "/a\nlist", "/a\"", "/(a)", &"/x".repeat(200)] {
            assert!(!is_name(name), "{name}");
        }
    }
}
