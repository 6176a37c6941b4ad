//! A WebSocket of bytes, for what no honest client sends.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(60);

/// A connection.
#[derive(Debug)]
pub(super) struct Raw(pub(super) TcpStream);

impl Raw {
    pub(super) fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("it listens");
        stream.set_read_timeout(Some(WATCHDOG)).expect("a time");
        stream.set_write_timeout(Some(WATCHDOG)).expect("a time");
        Self(stream)
    }

    /// Asks for a WebSocket with these headers in place of the usual ones of the same name; the head
    /// of the reply.
    pub(super) fn greet(address: &str, target: &str, headers: &[(&str, &str)]) -> (Self, String) {
        let mut raw = Self::connect(address);
        let usual = [
            ("Host", address),
            ("Connection", "Upgrade"),
            ("Upgrade", "websocket"),
            ("Sec-WebSocket-Version", "13"),
            ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
            ("Sec-WebSocket-Protocol", "foxglove.sdk.v1"),
        ];
        let mut head = format!("GET {target} HTTP/1.1\r\n");
        let kept = usual.iter().filter(|(name, _)| headers.iter().all(|(other, _)| other != name));
        for (name, value) in kept.chain(headers).filter(|(_, value)| *value != "NONE") {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        raw.0.write_all(format!("{head}\r\n").as_bytes()).expect("it reads");
        let reply = raw.head();
        (raw, reply)
    }

    /// The head of a reply, and its body if it is no WebSocket.
    fn head(&mut self) -> String {
        let mut text = Vec::new();
        let mut byte = [0];
        while !text.ends_with(b"\r\n\r\n") && self.0.read(&mut byte).is_ok_and(|read| read == 1) {
            text.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&text).into_owned();
        let length = head.lines().find_map(|line| {
            line.to_ascii_lowercase().strip_prefix("content-length: ")?.parse().ok()
        });
        let mut body = vec![0; length.unwrap_or(0)];
        self.0.read_exact(&mut body).expect("the body");
        format!("{head}{}", String::from_utf8_lossy(&body))
    }

    /// Sends a masked frame: final, of this kind (1 text, 2 binary), with this length in its head.
    pub(super) fn frame(&mut self, kind: u8, length: u64, content: &[u8]) -> std::io::Result<()> {
        let mut bytes = vec![0x80 | kind];
        match length {
            0..126 => bytes.push(0x80 | length as u8),
            126..65_536 => {
                bytes.push(0x80 | 126);
                bytes.extend((length as u16).to_be_bytes());
            }
            _ => {
                bytes.push(0x80 | 127);
                bytes.extend(length.to_be_bytes());
            }
        }
        bytes.extend([0; 4]);
        bytes.extend(content);
        self.0.write_all(&bytes)
    }

    /// Reads until what was sent contains this text so often.
    pub(super) fn hears(&mut self, text: &str, count: usize) -> String {
        let (mut heard, mut bytes) = (Vec::new(), [0; 4096]);
        loop {
            let told = String::from_utf8_lossy(&heard).into_owned();
            if told.matches(text).count() >= count {
                return told;
            }
            let read = self.0.read(&mut bytes).expect("it says something");
            assert!(read > 0, "it ends after {told}");
            heard.extend(&bytes[..read]);
        }
    }

    /// Waits until the other side closed the connection; what it had sent.
    pub(super) fn closed(mut self) -> Vec<u8> {
        let mut sent = Vec::new();
        match self.0.read_to_end(&mut sent) {
            Ok(_) => sent,
            Err(error) => {
                let kind = error.kind();
                assert_eq!(kind, std::io::ErrorKind::ConnectionReset, "{error}");
                sent
            }
        }
    }
}
