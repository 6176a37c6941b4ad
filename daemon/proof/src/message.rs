//! What clients and daemons say to each other by a relay: a line of JSON, then bytes.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::hex::Bytes;
use crate::key::{HINT, MAC, NONCE};

/// What comes to a daemon.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToDaemon {
    /// Somebody wants to talk; says nothing of what about.
    Hello(Hello),
    /// A [`Question`] is the body, in a session.
    Sealed(SealedQuestion),
}

/// The beginning of a session.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// Name of the daemon that is meant.
    pub daemon: String,
    /// Chosen by the client.
    pub nonce: Bytes<NONCE>,
    /// By what the daemon finds the token.
    pub hint: Bytes<HINT>,
}

/// Says in which session a question is, and that the client asks it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SealedQuestion {
    /// As in the hello.
    pub nonce: Bytes<NONCE>,
    /// As in the hello.
    pub hint: Bytes<HINT>,
    /// As in the daemon's answer to it.
    pub cookie: Bytes<NONCE>,
    /// Each question of a session has another one.
    pub number: u64,
    /// Authentication code of number and body.
    pub mac: Bytes<MAC>,
}

/// What comes from a daemon.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FromDaemon {
    /// Answer to a hello.
    Hello {
        /// Which end of the middleware the daemon is.
        at: String,
        /// Chosen by the daemon.
        cookie: Bytes<NONCE>,
        /// That it holds the token.
        proof: Bytes<MAC>,
    },
    /// An [`Answer`] is the body.
    Sealed {
        /// Authentication code of the question's number and the body.
        mac: Bytes<MAC>,
    },
    /// It does not listen. Nobody vouches for who said so.
    Refused {
        /// Stable name of the reason.
        code: String,
        /// One sentence.
        message: String,
    },
}

/// What a client wants of a daemon.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// A request as by HTTP, with its body.
    Request(Request),
    /// What a stream has sent since it was asked last.
    More(u64),
    /// Nobody reads that stream any more.
    End(u64),
}

/// A request as by HTTP, as far as it is passed on.
#[derive(Debug, Deserialize, Serialize)]
pub struct Request {
    /// `GET`, `POST` ...
    pub method: String,
    /// Path and query.
    pub path: String,
    /// Number of the last event seen, of a stream that goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_event_id: Option<String>,
}

/// What the daemon answers, with the body or what there is of it.
#[derive(Debug, Default, Deserialize, Serialize)]
pub struct Answer {
    /// As by HTTP.
    pub status: u16,
    /// As by HTTP.
    pub content_type: String,
    /// There is more, or will be: ask for it by this number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream: Option<u64>,
}

/// One message.
#[must_use]
pub fn encode(head: &impl Serialize, body: &[u8]) -> Vec<u8> {
    // No head of ours can fail to be JSON, which has no line breaks here.
    let mut bytes = serde_json::to_vec(head).unwrap_or_default();
    bytes.push(b'\n');
    bytes.extend_from_slice(body);
    bytes
}

/// The parts of a message.
///
/// # Errors
/// The head is not what it should be.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), serde_json::Error> {
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    let (head, body) = bytes.split_at(end);
    Ok((serde_json::from_slice(head)?, body.get(1..).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_go_with_a_message() {
        let request = Request { method: "a\nb".into(), path: "/".into(), last_event_id: None };
        let bytes = encode(&Question::Request(request), b"\n\xff\0");
        let (head, body) = decode::<Question>(&bytes).unwrap();
        assert!(matches!(head, Question::Request(read) if read.method == "a\nb"));
        assert_eq!(body, b"\n\xff\0");
        assert!(decode::<Question>(b"").is_err());
        assert!(decode::<Answer>(b"{\"status\": 200}").is_err());
    }
}
