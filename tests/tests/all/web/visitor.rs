//! What a browser or an attacker sends to a console, byte by byte.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;

use genom_tests::{Daemon, Home, WATCHDOG, component, path};
use serde_json::{Value, json};

/// Starts a daemon with a console and the demo; these words precede.
#[track_caller]
pub(super) fn demo(home: Home, arguments: &[&str]) -> Daemon {
    let demo = component("demo");
    home.start(&[&["--web"], arguments, &[path(&demo.library)]].concat())
}

/// Sets the speed of the axis, in m/s, also while it moves: a motion at 0.01 m/s is there for as
/// long as a test has to look at it.
#[track_caller]
pub(super) fn set_speed(daemon: &Daemon, speed: &str) {
    daemon.ctl(&["call", "demo", "set_speed", &format!("velocity={speed}")]).expect_code(0);
}

/// A link that opens the console of this daemon.
#[track_caller]
pub(super) fn link(daemon: &Daemon, arguments: &[&str]) -> String {
    let made = daemon.json(&[&["web"], arguments].concat());
    made["url"].as_str().expect("a link").to_owned()
}

/// A reply.
#[derive(Debug)]
pub(super) struct Reply {
    /// HTTP status.
    pub(super) status: u16,
    /// Its head, in small letters but for values.
    pub(super) head: String,
    /// Its body.
    pub(super) body: String,
}

impl Reply {
    /// The value of a header.
    pub(super) fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|(found, _)| found.eq_ignore_ascii_case(name)).map(|(_, value)| value)
    }

    /// Its body as JSON.
    pub(super) fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_default()
    }

    /// Code of a refusal.
    pub(super) fn code(&self) -> String {
        self.json()["error"]["code"].as_str().unwrap_or_default().to_owned()
    }

    /// `NAME=SECRET` of the cookie that it sets.
    #[track_caller]
    pub(super) fn cookie(&self) -> String {
        let set = self.header("set-cookie").expect("it sets a cookie");
        set.split(';').next().expect("a cookie").to_owned()
    }
}

/// Whoever talks to a console.
#[derive(Clone, Debug)]
pub(super) struct Visitor {
    /// Address of the console.
    pub(super) address: String,
    /// `Host` of its requests.
    pub(super) host: String,
    /// Further headers, such as that of its page.
    pub(super) headers: Vec<String>,
}

impl Visitor {
    /// Somebody without a session, on a page of the console.
    pub(super) fn stranger(link: &str) -> Self {
        let address = link.trim_start_matches("http://").split('/').next().expect("an address");
        let headers = vec![format!("Origin: http://{address}")];
        Self { address: address.to_owned(), host: address.to_owned(), headers }
    }

    /// Whoever opens this link.
    #[track_caller]
    pub(super) fn with_link(link: &str) -> Self {
        let stranger = Self::stranger(link);
        let reply = stranger.opens(link);
        assert_eq!(reply.status, 200, "{reply:?}");
        stranger.with(&format!("Cookie: {}", reply.cookie()))
    }

    /// The same with another header.
    pub(super) fn with(&self, header: &str) -> Self {
        let mut with = self.clone();
        with.headers.push(header.to_owned());
        with
    }

    /// The same from another page.
    pub(super) fn on_page(&self, origin: &str) -> Self {
        let mut from = self.clone();
        from.headers.retain(|header| !header.starts_with("Origin:"));
        if !origin.is_empty() {
            from.headers.push(format!("Origin: {origin}"));
        }
        from
    }

    /// The same under another name of the console.
    pub(super) fn under(&self, host: &str) -> Self {
        let mut under = self.on_page(&format!("http://{host}"));
        host.clone_into(&mut under.host);
        under
    }

    /// Opens a link, as its page does.
    pub(super) fn opens(&self, link: &str) -> Reply {
        let secret = link.split_once('#').expect("a link has a secret").1;
        self.posts("/session", &json!({ "link": secret }).to_string())
    }

    /// Signs in with a token.
    pub(super) fn shows(&self, token: &str) -> Reply {
        self.posts("/session", &json!({ "token": token }).to_string())
    }

    pub(super) fn gets(&self, path: &str) -> Reply {
        self.sends("GET", path, "")
    }

    pub(super) fn posts(&self, path: &str, body: &str) -> Reply {
        self.sends("POST", path, body)
    }

    /// Sends a request, and reads the whole reply.
    pub(super) fn sends(&self, method: &str, path: &str, body: &str) -> Reply {
        let mut reader = self.begins(method, path, body);
        let (status, head) = read_head(&mut reader);
        let mut body = Vec::new();
        let _ = reader.read_to_end(&mut body);
        Reply { status, head, body: String::from_utf8_lossy(&body).into_owned() }
    }

    /// Opens a stream; the reader is at its first line.
    #[track_caller]
    pub(super) fn follows(&self, path: &str) -> BufReader<TcpStream> {
        let mut reader = self.begins("GET", path, "");
        let (status, head) = read_head(&mut reader);
        assert_eq!(status, 200, "{head}");
        reader
    }

    /// Opens a stream and leaves it; returns the status.
    pub(super) fn looks_into(&self, path: &str) -> u16 {
        read_head(&mut self.begins("GET", path, "")).0
    }

    fn begins(&self, method: &str, path: &str, body: &str) -> BufReader<TcpStream> {
        let mut stream = TcpStream::connect(&self.address).expect("the console listens");
        stream.set_read_timeout(Some(WATCHDOG)).expect("a time-out can be set");
        let headers: String = self.headers.iter().map(|header| format!("{header}\r\n")).collect();
        let (host, length) = (&self.host, body.len());
        // A console that refuses before it has read everything may close the connection.
        let _ = write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\
             Content-Length: {length}\r\n\r\n{body}"
        );
        BufReader::new(stream)
    }
}

fn read_head(reader: &mut BufReader<TcpStream>) -> (u16, String) {
    let mut head = String::new();
    loop {
        let mut line = String::new();
        let read = reader.read_line(&mut line).expect("a reply");
        if read == 0 || line == "\r\n" {
            break;
        }
        head.push_str(&line);
    }
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    (status.expect("a status"), head)
}

/// The next message of a live stream for which this holds.
#[track_caller]
pub(super) fn next(reader: &mut BufReader<TcpStream>, wanted: impl Fn(&Value) -> bool) -> Value {
    loop {
        let mut line = String::new();
        let read = reader.read_line(&mut line).expect("the stream goes on");
        assert_ne!(read, 0, "the stream ended");
        let Some(data) = line.strip_prefix("data: ") else { continue };
        let message = serde_json::from_str(data).expect("JSON");
        if wanted(&message) {
            return message;
        }
    }
}
