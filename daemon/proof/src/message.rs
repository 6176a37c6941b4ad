//! The messages between clients and daemons that a relay passes on: one line of JSON (the head),
//! then bytes (the body).

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::hex::Bytes;
use crate::key::{HINT, MAC, NONCE};

/// The head of a message to a daemon.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToDaemon {
    /// Opens a session; does not tell what the client wants.
    Hello(Hello),
    /// A question within a session. The body is a [`Question`] and the body of its request.
    Sealed(SealedQuestion),
}

/// The beginning of a session.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// Name of the daemon that is asked for.
    pub daemon: String,
    /// Random bytes chosen by the client.
    pub nonce: Bytes<NONCE>,
    /// By this the daemon finds the token.
    pub hint: Bytes<HINT>,
}

/// Tells which session a question belongs to, and proves that the client of that session sent it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SealedQuestion {
    /// Nonce of the hello.
    pub nonce: Bytes<NONCE>,
    /// Hint of the hello.
    pub hint: Bytes<HINT>,
    /// Cookie of the daemon's answer to the hello.
    pub cookie: Bytes<NONCE>,
    /// Number of the question, used only once in a session.
    pub number: u64,
    /// Authentication code of the number and the body.
    pub mac: Bytes<MAC>,
}

/// The head of a message from a daemon.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FromDaemon {
    /// The answer to a hello.
    Hello {
        /// Identity of the daemon's endpoint on the middleware.
        at: String,
        /// Random bytes chosen by the daemon.
        cookie: Bytes<NONCE>,
        /// Proof that the daemon holds the token.
        proof: Bytes<MAC>,
    },
    /// The answer to a question. The body is an [`Answer`] and its content.
    Sealed {
        /// Authentication code of the question's number and the body.
        mac: Bytes<MAC>,
    },
    /// A refusal. It is not authenticated.
    Refused {
        /// Stable name of the reason, for programs.
        code: String,
        /// The reason as one sentence.
        message: String,
    },
}

/// What a client asks of a daemon within a session.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// A request as over HTTP, followed by its body.
    Request(Request),
    /// What stream `.0` has sent since the last such question.
    More(u64),
    /// The client no longer reads stream `.0`.
    End(u64),
}

/// An HTTP request, reduced to what the relay supports.
#[derive(Debug, Deserialize, Serialize)]
pub struct Request {
    /// HTTP method: `GET`, `POST` ...
    pub method: String,
    /// Path and query.
    pub path: String,
    /// Number of the last event received, to resume a stream of events.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_event_id: Option<String>,
}

/// The daemon's answer, followed by its body, or by the part of it that is available.
#[derive(Debug, Default, Deserialize, Serialize)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// HTTP content type.
    pub content_type: String,
    /// Set if the body goes on: the number of the stream to ask for more of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream: Option<u64>,
}

/// The bytes of a message: head and body.
#[must_use]
pub fn encode(head: &impl Serialize, body: &[u8]) -> Vec<u8> {
    // None of the heads can fail to serialise, and `serde_json` writes no line breaks here.
    let mut bytes = serde_json::to_vec(head).unwrap_or_default();
    bytes.push(b'\n');
    bytes.extend_from_slice(body);
    bytes
}

/// Splits a message into head and body.
///
/// # Errors
/// The head is not JSON of type `T`.
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
