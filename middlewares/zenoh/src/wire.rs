//! Metadata of payloads: encoding with type and digest, marks of samples, kinds of replies.

use genom_types::DataType;
use serde_json::{Value, json};
use zenoh::bytes::{Encoding, ZBytes};

/// Precedes the digest in the schema of an encoding.
const DIGEST: &str = "digest=";

/// Attachments of a service's replies.
pub(crate) const ACCEPTED: &[u8] = b"accepted";
pub(crate) const FEEDBACK: &[u8] = b"feedback";
pub(crate) const RESULT: &[u8] = b"result";

/// The encoding of a type: `application/cdr;demo::state;digest=..`.
pub(crate) fn encoding_of(ty: &DataType) -> Encoding {
    let name = ty.name().trim_start_matches("::");
    Encoding::APPLICATION_CDR.with_schema(format!("{name};digest={}", ty.digest()))
}

/// The encoding that messages of a type should have.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    pub(crate) encoding: Encoding,
    digest: String,
}

impl Expected {
    pub(crate) fn of(ty: &DataType) -> Self {
        Self { encoding: encoding_of(ty), digest: ty.digest().to_owned() }
    }

    /// Whether a message with this encoding may be of the type. Foreign messages may have none.
    pub(crate) fn admits(&self, encoding: &Encoding) -> bool {
        *encoding == self.encoding
            || match encoding.to_string().rsplit_once(DIGEST) {
                Some((_, digest)) => digest == self.digest,
                None => true,
            }
    }
}

/// Identifies a sample and its writer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    /// Differs between any two writers.
    pub(crate) writer: u64,
    /// Sequence number, from 1.
    pub(crate) number: u64,
}

impl Mark {
    pub(crate) fn to_bytes(self) -> [u8; 16] {
        let mut bytes = [0; 16];
        let (writer, number) = bytes.split_at_mut(8);
        writer.copy_from_slice(&self.writer.to_le_bytes());
        number.copy_from_slice(&self.number.to_le_bytes());
        bytes
    }

    /// Parses an attachment; `None` if it is a foreign one.
    pub(crate) fn from_attachment(attachment: Option<&ZBytes>) -> Option<Self> {
        let bytes = attachment.filter(|bytes| bytes.len() == 16)?.to_bytes();
        let (writer, number) = bytes.split_at_checked(8)?;
        Some(Self {
            writer: u64::from_le_bytes(writer.try_into().ok()?),
            number: u64::from_le_bytes(number.try_into().ok()?),
        })
    }
}

/// Why a request got no reply from the service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The service has these other types.
    Types(String),
    /// The request or the reply cannot be decoded.
    Serialization(String),
    /// The service went away.
    Gone,
    /// Anything else.
    Failed(String),
}

impl Refusal {
    pub(crate) fn to_json(&self) -> Value {
        let (error, detail) = match self {
            Self::Types(theirs) => ("types", theirs.as_str()),
            Self::Serialization(why) => ("serialization", why.as_str()),
            Self::Gone => ("gone", ""),
            Self::Failed(why) => ("failed", why.as_str()),
        };
        json!({"error": error, "detail": detail})
    }
}

/// Content of an error reply.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ErrorReply {
    /// The service ended with this exception.
    Exception(String, Value),
    Refusal(Refusal),
}

/// Parses an error reply of our own or of a foreign server.
pub(crate) fn read_error(payload: &[u8]) -> ErrorReply {
    let words = || String::from_utf8_lossy(payload).into_owned();
    let failed = || ErrorReply::Refusal(Refusal::Failed(words()));
    let Ok(Value::Object(mut members)) = serde_json::from_slice(payload) else { return failed() };
    let detail = members.remove("detail").unwrap_or_default();
    if let Some(Value::String(name)) = members.remove("exception") {
        return ErrorReply::Exception(name, detail);
    }
    let detail = detail.as_str().map(str::to_owned).unwrap_or_default();
    ErrorReply::Refusal(match members.get("error").and_then(Value::as_str) {
        Some("types") => Refusal::Types(detail),
        Some("serialization") => Refusal::Serialization(detail),
        Some("gone") => Refusal::Gone,
        Some("failed") => Refusal::Failed(detail),
        _ => return failed(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_conformance::samples::{other_state, state};

    #[test]
    fn a_digest_that_differs_is_seen_and_none_is_accepted() {
        let ours = Expected::of(&state());
        assert!(ours.admits(&encoding_of(&state())));
        assert!(!ours.admits(&encoding_of(&other_state())));
        let digest = state().digest().to_owned();
        let renamed = format!("my::pose;digest={digest}");
        assert!(ours.admits(&Encoding::APPLICATION_CDR.with_schema(renamed)));
        assert!(ours.admits(&Encoding::ZENOH_BYTES));
        assert!(ours.admits(&Encoding::APPLICATION_CDR.with_schema("any::type")));
    }

    #[test]
    fn refusals_and_exceptions_are_read_as_written() {
        for refusal in [
            Refusal::Types("::demo::state".to_owned()),
            Refusal::Serialization("too short".to_owned()),
            Refusal::Gone,
            Refusal::Failed("why".to_owned()),
        ] {
            let text = refusal.to_json().to_string();
            assert_eq!(read_error(text.as_bytes()), ErrorReply::Refusal(refusal));
        }
        let raised = br#"{"exception": "::demo::E", "detail": {"a": 1}}"#;
        let expected = ErrorReply::Exception("::demo::E".to_owned(), json!({"a": 1}));
        assert_eq!(read_error(raised), expected);
        for other in [&b"\xff\xfe"[..], b"no json", b"[]", b"{}", b"{\"error\": 3}"] {
            assert!(matches!(read_error(other), ErrorReply::Refusal(Refusal::Failed(_))));
        }
    }
}
