//! Section `[backends.yarp]` of the configuration, and where YARP's own files say that the name
//! server is.

use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Deserialize;

use crate::error::YarpError;
use crate::names::is_name;
use crate::wire::Carrier;

/// Port of a name server that nothing else is known of.
const DEFAULT_PORT: u16 = 10000;

/// Name of the name server that nothing else is known of.
const DEFAULT_NAMESPACE: &str = "/root";

/// Greatest `largest_message`.
const MOST_MESSAGE: usize = 1 << 30;

/// Greatest `answer_within`: a year.
const MOST_PATIENCE: Duration = Duration::from_secs(365 * 24 * 3600);

/// Section `[backends.yarp]` of the configuration.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Address of the name server, `HOST:PORT`. Empty: as YARP's own programs find it.
    pub server: String,
    /// Name of the name server ("YARP namespace"). Empty: as YARP's own programs find it.
    pub namespace: String,
    /// What all names begin with, such as `/robot1`. Empty for nothing.
    pub prefix: String,
    /// Address of this machine at which ports listen, and which is registered.
    pub listen: String,
    /// Whether other machines may connect. YARP asks nobody who he is.
    pub insecure: bool,
    /// Carrier of connections that in ports ask for: `tcp` or `fast_tcp`.
    pub carrier: String,
    /// Greatest size in bytes of a message that is accepted, for types without a greatest size.
    pub largest_message: usize,
    /// Seconds that a server that is no genomd may take to answer a request; 0 for any time.
    pub answer_within: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            server: String::new(),
            namespace: String::new(),
            prefix: String::new(),
            listen: "127.0.0.1".to_owned(),
            insecure: false,
            carrier: "fast_tcp".to_owned(),
            largest_message: 64 << 20,
            answer_within: 0.0,
        }
    }
}

/// Options that were checked.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Address of the name server.
    pub(crate) server: (String, u16),
    pub(crate) namespace: String,
    /// Begins with a slash, and does not end with one; or empty.
    pub(crate) prefix: String,
    pub(crate) listen: IpAddr,
    pub(crate) carrier: Carrier,
    pub(crate) largest_message: usize,
    /// How long a server that is no genomd may take to answer; `None` for any time.
    pub(crate) answer_within: Option<Duration>,
}

impl Options {
    /// Checks all that needs no file.
    pub(crate) fn check(&self) -> Result<(), YarpError> {
        self.settle(&|_| None, false).map(|_| ())
    }

    /// The options with what the environment and YARP's files say.
    pub(crate) fn settings(&self) -> Result<Settings, YarpError> {
        self.settle(&|name| std::env::var_os(name).map(PathBuf::from), true)
    }

    fn settle(
        &self,
        variable: &dyn Fn(&str) -> Option<PathBuf>,
        files: bool,
    ) -> Result<Settings, YarpError> {
        let listen: IpAddr =
            self.listen.parse().map_err(|_| YarpError::Listen(self.listen.clone()))?;
        if listen.is_unspecified() {
            return Err(YarpError::Listen(self.listen.clone()));
        }
        if !listen.is_loopback() && !self.insecure {
            return Err(YarpError::Insecure(self.listen.clone()));
        }
        let prefix = match self.prefix.trim_matches('/') {
            "" => String::new(),
            prefix => format!("/{prefix}"),
        };
        if !prefix.is_empty() && !is_name(&prefix) {
            return Err(YarpError::Prefix(self.prefix.clone()));
        }
        let carrier = Carrier::named(&self.carrier)
            .ok_or_else(|| YarpError::Carrier(self.carrier.clone()))?;
        let folders = if files { Folders::of(variable) } else { Folders::default() };
        let namespace = match self.namespace.as_str() {
            "" => folders.namespace()?,
            name => name.to_owned(),
        };
        if !is_name(&namespace) {
            return Err(YarpError::Namespace(namespace));
        }
        let server = match self.server.as_str() {
            "" => folders.server(&namespace)?,
            address => address_of(address)?,
        };
        let largest_message = self.largest_message.clamp(1 << 12, MOST_MESSAGE);
        let within = Duration::try_from_secs_f64(self.answer_within).ok();
        let within = within.filter(|within| *within <= MOST_PATIENCE);
        let within = within.ok_or(YarpError::AnswerWithin(self.answer_within))?;
        let answer_within = (!within.is_zero()).then_some(within);
        Ok(Settings { server, namespace, prefix, listen, carrier, largest_message, answer_within })
    }
}

fn address_of(text: &str) -> Result<(String, u16), YarpError> {
    let wrong = || YarpError::Server(text.to_owned());
    let (host, port) = text.rsplit_once(':').ok_or_else(wrong)?;
    let host = host.trim_start_matches('[').trim_end_matches(']');
    match port.parse() {
        Ok(port) if port > 0 && !host.is_empty() => Ok((host.to_owned(), port)),
        _ => Err(wrong()),
    }
}

/// Where YARP's files are.
#[derive(Debug, Default)]
struct Folders {
    configuration: Option<PathBuf>,
}

impl Folders {
    /// As `yarp conf` finds them.
    fn of(variable: &dyn Fn(&str) -> Option<PathBuf>) -> Self {
        let set = |name: &str| variable(name).filter(|path| !path.as_os_str().is_empty());
        let configuration = set("YARP_CONFIG_HOME")
            .or_else(|| set("YARP_CONF"))
            .or_else(|| set("XDG_CONFIG_HOME").map(|folder| folder.join("yarp")))
            .or_else(|| set("HOME").map(|folder| folder.join(".config/yarp")));
        Self { configuration }
    }

    fn first_line(&self, name: &str) -> Result<Option<(PathBuf, String)>, YarpError> {
        let Some(path) = self.configuration.as_ref().map(|folder| folder.join(name)) else {
            return Ok(None);
        };
        match read(&path) {
            Ok(text) => {
                let mut lines = text.lines().map(str::trim);
                let line = lines.find(|line| !line.is_empty()).unwrap_or_default().to_owned();
                Ok(Some((path, line)))
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(YarpError::Unreadable { path, source }),
        }
    }

    /// The file that `yarp namespace NAME` writes.
    fn namespace(&self) -> Result<String, YarpError> {
        let line = self.first_line("yarp_namespace.conf")?.map(|(_, line)| line);
        Ok(line.filter(|line| !line.is_empty()).unwrap_or_else(|| DEFAULT_NAMESPACE.to_owned()))
    }

    /// The file that `yarp conf HOST PORT` writes, and `yarpserver --write`.
    fn server(&self, namespace: &str) -> Result<(String, u16), YarpError> {
        let name = match namespace {
            DEFAULT_NAMESPACE => "yarp.conf".to_owned(),
            other => format!("{}.conf", other.replace('/', "_")),
        };
        let Some((path, line)) = self.first_line(&name)? else {
            return Ok(("127.0.0.1".to_owned(), DEFAULT_PORT));
        };
        let mut words = line.split_ascii_whitespace();
        let (host, port) = (words.next(), words.next().and_then(|port| port.parse().ok()));
        match (host, port, words.next()) {
            (Some(host), Some(port), Some("yarp") | None) if port > 0 => {
                Ok((host.to_owned(), port))
            }
            _ => Err(YarpError::File { path, line }),
        }
    }
}

/// Reads a file of a few lines.
fn read(path: &Path) -> std::io::Result<String> {
    use std::io::Read as _;
    let mut text = Vec::new();
    std::fs::File::open(path)?.take(4096).read_to_end(&mut text)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(options: &Options, folder: &Path) -> Result<Settings, YarpError> {
        let variable = |name: &str| (name == "YARP_CONFIG_HOME").then(|| folder.to_owned());
        options.settle(&variable, true)
    }

    #[test]
    fn the_name_server_is_where_yarp_users_say() {
        let folder = tempfile::tempdir().unwrap();
        let server = |options: &Options| settle(options, folder.path()).map(|found| found.server);
        let (none, at) = (Options::default(), |host: &str, port| (host.to_owned(), port));
        assert_eq!(server(&none).unwrap(), at("127.0.0.1", 10000));
        let file = folder.path().join("yarp.conf");
        std::fs::write(&file, "192.0.2.2 10444 yarp\n").unwrap();
        assert_eq!(server(&none).unwrap(), at("192.0.2.2", 10444));
        let given = Options { server: "robot:10001".to_owned(), ..Options::default() };
        assert_eq!(server(&given).unwrap(), at("robot", 10001));
        std::fs::write(&file, "somewhere else\n").unwrap();
        let error = server(&none).unwrap_err().to_string();
        assert!(error.contains("yarp.conf") && error.contains("somewhere else"), "{error}");
        // `yarp namespace /robot1` says which name server, and a file of its name where it is.
        std::fs::write(folder.path().join("yarp_namespace.conf"), "/robot1\n").unwrap();
        std::fs::write(folder.path().join("_robot1.conf"), "10.0.0.7 10002 yarp\n").unwrap();
        let found = settle(&none, folder.path()).unwrap();
        assert_eq!((found.namespace.as_str(), found.server), ("/robot1", at("10.0.0.7", 10002)));
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_its_key() {
        for (text, said) in [
            ("server = 'here'", "server = \"here\""),
            ("server = 'here:0'", "HOST:PORT"),
            ("listen = 'eth0'", "listen = \"eth0\""),
            ("listen = '0.0.0.0'", "listen = \"0.0.0.0\""),
            ("listen = '192.0.2.2'", "insecure = true"),
            ("prefix = 'a b'", "prefix = \"a b\""),
            ("namespace = 'root'", "namespace = \"root\""),
            ("carrier = 'udp'", "fast_tcp"),
            ("answer_within = -1.0", "answer_within = -1"),
            ("answer_within = nan", "answer_within = NaN"),
        ] {
            let options: Options = toml::from_str(text).unwrap();
            let error = options.check().unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
        assert!(toml::from_str::<Options>("servers = 'x'").is_err());
        let open: Options = toml::from_str("listen = '192.0.2.2'\ninsecure = true").unwrap();
        open.check().unwrap();
    }
}
