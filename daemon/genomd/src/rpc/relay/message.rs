//! What daemons say to each other by a relay: a line of JSON, then the bytes of a body.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// What one daemon wants of another.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Question {
    /// A request as by HTTP, with its body.
    Request(Request),
    /// What a stream has sent since it was asked last.
    More(String),
    /// Nobody reads that stream any more.
    End(String),
}

/// A request as by HTTP, as far as it is passed on.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Request {
    pub(super) method: String,
    /// Path and query.
    pub(super) path: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) authorization: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) last_event_id: Option<String>,
}

/// What the other one answers, with the body or what there is of it.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(super) struct Answer {
    pub(super) status: u16,
    pub(super) content_type: String,
    /// There is more, or will be: ask for it by this name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) stream: Option<String>,
}

/// One message.
pub(super) fn encode(head: &impl Serialize, body: &[u8]) -> Vec<u8> {
    // Neither questions nor answers can fail to be JSON, which has no line breaks here.
    let mut bytes = serde_json::to_vec(head).unwrap_or_default();
    bytes.push(b'\n');
    bytes.extend_from_slice(body);
    bytes
}

/// The parts of a message.
pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), serde_json::Error> {
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    let (head, body) = bytes.split_at(end);
    Ok((serde_json::from_slice(head)?, body.get(1..).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_go_with_a_message() {
        let bytes = encode(&Question::More("a\nb".to_owned()), b"\n\xff\0");
        let (head, body) = decode::<Question>(&bytes).unwrap();
        assert!(matches!(head, Question::More(name) if name == "a\nb"));
        assert_eq!(body, b"\n\xff\0");
        assert!(decode::<Question>(b"").is_err());
        assert!(decode::<Answer>(b"{\"status\": 200}").is_err());
    }
}
