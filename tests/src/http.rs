//! Raw HTTP on the daemon's socket, for requests that genomctl never sends.

use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Instant;

use serde_json::Value;

use crate::WATCHDOG;

/// A reply.
#[derive(Debug)]
pub struct Reply {
    /// HTTP status.
    pub status: u16,
    /// Body as JSON; null if it is not JSON.
    pub body: Value,
}

impl Reply {
    /// Stable code of a refusal.
    #[must_use]
    pub fn code(&self) -> &str {
        self.body["error"]["code"].as_str().unwrap_or_default()
    }
}

/// Opens a connection to a daemon.
#[must_use]
pub fn connect(socket: &Path) -> UnixStream {
    let stream = UnixStream::connect(socket).expect("the daemon listens");
    stream.set_read_timeout(Some(WATCHDOG)).expect("a time-out can be set");
    stream
}

/// Sends one request on a connection of its own.
#[must_use]
pub fn request(socket: &Path, method: &str, path: &str, body: &str) -> Reply {
    attempt(socket, method, path, body).expect("the daemon answers")
}

/// The same for a daemon that may be gone, or end meanwhile.
pub(crate) fn attempt(socket: &Path, method: &str, path: &str, body: &str) -> io::Result<Reply> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(WATCHDOG))?;
    let length = body.len();
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\
         Content-Length: {length}\r\n\r\n{body}"
    )?;
    let mut text = String::new();
    stream.read_to_string(&mut text)?;
    let status = text.split(' ').nth(1).and_then(|code| code.parse().ok());
    let status = status.ok_or(io::ErrorKind::UnexpectedEof)?;
    let body = text.split_once("\r\n\r\n").map_or("", |(_, body)| body);
    Ok(Reply { status, body: serde_json::from_str(body).unwrap_or_default() })
}

/// Stream of a daemon's events.
#[derive(Debug)]
pub struct Events {
    lines: std::io::Lines<BufReader<UnixStream>>,
}

impl Events {
    /// Opens the stream; it is open when this returns.
    #[must_use]
    pub(crate) fn open(socket: &Path) -> Self {
        let mut stream = connect(socket);
        write!(stream, "GET /events HTTP/1.1\r\nHost: x\r\n\r\n").expect("the daemon reads");
        let mut lines = BufReader::new(stream).lines();
        let status = lines.next().expect("an answer").expect("a line");
        assert!(status.contains("200"), "{status}");
        // The head ends with an empty line; the daemon subscribes before it sends it.
        while !lines.next().expect("a head").expect("a line").is_empty() {}
        Self { lines }
    }

    /// Waits for the next event that `wanted` accepts; skips those before it.
    ///
    /// # Panics
    /// If none comes in time.
    #[track_caller]
    pub fn wait_for(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        let (end, mut seen) = (Instant::now() + WATCHDOG, Vec::new());
        loop {
            // The daemon sends an empty comment now and then, so that reading alone never times out.
            assert!(Instant::now() < end, "this never came; seen: {seen:#?}");
            let line = match self.lines.next() {
                Some(Ok(line)) => line,
                end => panic!("the stream ended ({end:?}); seen: {seen:#?}"),
            };
            let Some(data) = line.strip_prefix("data: ") else { continue };
            let change: Value = serde_json::from_str(data).expect("JSON");
            if wanted(&change) {
                return change;
            }
            seen.push(change);
        }
    }

    /// Events up to and including one that `last` accepts.
    #[track_caller]
    pub fn until(&mut self, last: impl Fn(&Value) -> bool) -> Vec<Value> {
        let all = std::cell::RefCell::new(Vec::new());
        self.wait_for(|change| {
            all.borrow_mut().push(change.clone());
            last(change)
        });
        all.into_inner()
    }
}
