//! Bodies of requests and replies: a record, and a few fields encoded by hand around it.

use genom_middleware::{CallError, Outcome};
use genom_rosidl::{Failure, Manner};
use genom_types::{CdrError, DataType, Kind, Record};
use serde_json::Value;

use crate::rmw::HEADER;

/// Id of a goal, chosen by the client that sends it.
pub(crate) type GoalId = [u8; 16];

/// Exception that means: the service went away before it replied.
pub(crate) const GONE: &str = "::genom::gone";

/// Exception that means: the request could not be decoded.
const SERIALIZATION: &str = "::genom::serialization";

/// Exception of an interrupted activity (genom3.md 7.6).
pub(crate) const INTERRUPTED: &str = "::genom::interrupted";

/// `action_msgs/msg/GoalStatus`
pub(crate) const SUCCEEDED: u8 = 4;
pub(crate) const CANCELED: u8 = 5;
pub(crate) const ABORTED: u8 = 6;

/// Appends a string to a payload whose alignment starts at 0.
pub(crate) fn put_string(out: &mut Vec<u8>, text: &str) {
    // A CDR string ends at its NUL, so text with a NUL inside is cut there.
    let text = text.split('\0').next().unwrap_or_default();
    out.resize(out.len().next_multiple_of(4), 0);
    let length = u32::try_from(text.len() + 1).unwrap_or(u32::MAX);
    out.extend_from_slice(&length.to_le_bytes());
    out.extend_from_slice(text.as_bytes());
    out.push(0);
}

/// Appends the input of a service. ROS has no empty messages: one without members is one byte.
pub(crate) fn put_input(out: &mut Vec<u8>, input: &Record) -> Result<(), CdrError> {
    let before = out.len();
    input.encode_cdr_within(0, out)?;
    if out.len() == before {
        out.push(0);
    }
    Ok(())
}

/// What a response or result has beside the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// Name and detail of the exception, before the output.
    Genom,
    /// Nothing: the type is a foreign one.
    Foreign(Manner),
}

/// Appends the outcome of a service. Returns false if the response type cannot express it.
pub(crate) fn put_outcome(
    out: &mut Vec<u8>,
    ty: &DataType,
    outcome: &Outcome,
    style: Style,
) -> bool {
    let before = out.len();
    let (name, detail, output) = match outcome {
        Outcome::Success(output) => ("", Value::Null, Some(output)),
        Outcome::Exception { name, detail } => (name.as_str(), detail.clone(), None),
        Outcome::Lost(CallError::Serialization(why)) => {
            (SERIALIZATION, Value::String(why.clone()), None)
        }
        Outcome::Lost(error) => (GONE, Value::String(error.to_string()), None),
    };
    let detail = if detail.is_null() { String::new() } else { detail.to_string() };
    let encoded = match style {
        Style::Genom => {
            put_string(out, name);
            put_string(out, &detail);
            match output {
                Some(output) => output.encode_cdr_within(0, out),
                None => Record::new(ty).encode_cdr_within(0, out),
            }
        }
        Style::Foreign(manner) => match (manner.failure, output) {
            (Failure::Added, output) => {
                out.push(u8::from(output.is_some()));
                put_string(out, format!("{name} {detail}").trim());
                Ok(())
            }
            (_, Some(output)) => put_input(out, output),
            (Failure::Members(success, message), None) => {
                let text = format!("{name} {detail}");
                put_input(out, &failed(ty, success, message, text.trim()))
            }
            (Failure::Silent, None) => {
                // A result also has a status, which tells that it failed.
                return put_input(out, &Record::new(ty)).is_ok() && before > 0;
            }
        },
    };
    if let Err(error) = encoded
        && !matches!(outcome, Outcome::Lost(_))
    {
        out.truncate(before);
        let why = error.to_string();
        return put_outcome(out, ty, &Outcome::Lost(CallError::Serialization(why)), style);
    }
    true
}

/// An output with `success` false and the reason in `message`, cut to the size of that string.
fn failed(ty: &DataType, success: usize, message: usize, why: &str) -> Record {
    let mut output = Record::new(ty);
    let room = match ty.member(message).as_ref().map(DataType::kind) {
        Some(Kind::String { bound: Some(bound) }) => {
            usize::try_from(bound.saturating_sub(1)).unwrap_or_default()
        }
        _ => why.len(),
    };
    let end = (0..=room.min(why.len())).rev().find(|end| why.is_char_boundary(*end));
    let why = why.get(..end.unwrap_or_default()).unwrap_or_default();
    if let (Some(success), Some(message)) = (ty.member_name(success), ty.member_name(message)) {
        let told = serde_json::json!({ success: false, message: why });
        if let Err(error) = output.merge_json(&told) {
            tracing::debug!(%error, "an exception cannot be told");
        }
    }
    output
}

/// Parses the exception in a message of ours (`::demo::TOO_FAR {"by":3}`); any other text becomes
/// the middleware's own exception.
fn failure(message: &str) -> Outcome {
    let (name, detail) = message.split_once(' ').unwrap_or((message, ""));
    let known = name.strip_prefix("::").filter(|name| !name.is_empty());
    let detail = match detail {
        "" => Some(Value::Null),
        detail => serde_json::from_str(detail).ok(),
    };
    match (known, detail) {
        (Some(_), Some(detail)) => Outcome::Exception { name: name.to_owned(), detail },
        _ => {
            let what = if message.is_empty() { "it failed" } else { message };
            let name = "::genom::mwerr".to_owned();
            Outcome::Exception { name, detail: serde_json::json!({ "what": what }) }
        }
    }
}

/// Reads a message field by field. Each method returns `None` if the field is missing or invalid.
#[derive(Clone, Debug)]
pub(crate) struct Fields<'a> {
    payload: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Fields<'a> {
    /// Fields of the message's payload.
    pub(crate) fn of(message: &'a [u8]) -> Option<Self> {
        let (header, payload) = message.split_at_checked(HEADER)?;
        Some(Self { payload, at: 0, big_endian: header.get(1) != Some(&1) })
    }

    pub(crate) fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = self.payload.get(self.at..)?.first_chunk::<N>()?;
        self.at += N;
        Some(*bytes)
    }

    pub(crate) fn byte(&mut self) -> Option<u8> {
        self.bytes::<1>().map(|[byte]| byte)
    }

    pub(crate) fn word(&mut self) -> Option<u32> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.bytes()?;
        Some(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    pub(crate) fn long(&mut self) -> Option<u64> {
        self.at = self.at.next_multiple_of(8);
        let bytes = self.bytes()?;
        Some(if self.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    pub(crate) fn string(&mut self) -> Option<&'a str> {
        let length = usize::try_from(self.word()?).ok()?;
        let end = self.at.checked_add(length)?;
        let bytes = self.payload.get(self.at..end)?;
        self.at = end;
        // Some writers send an empty string without its NUL.
        std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes)).ok()
    }

    /// Decodes the rest of the payload as a record.
    pub(crate) fn record(&self, ty: &DataType) -> Result<Record, CdrError> {
        let mut record = Record::new(ty);
        record.decode_cdr_within(self.payload, self.at, self.big_endian)?;
        Ok(record)
    }

    /// Reads the outcome of a service; of an action if there is a `status`, its final one.
    pub(crate) fn outcome(&mut self, ty: &DataType, style: Style, status: Option<u8>) -> Outcome {
        match style {
            Style::Genom => self.own_outcome(ty, status),
            Style::Foreign(manner) => self.foreign_outcome(ty, manner, status),
        }
    }

    /// Reads the outcome from a ROS type, whoever sent it.
    fn foreign_outcome(&mut self, ty: &DataType, manner: Manner, status: Option<u8>) -> Outcome {
        let lost = |why: &str| Outcome::Lost(CallError::Serialization(why.to_owned()));
        let mut why = String::new();
        let output = if manner.failure == Failure::Added {
            let (Some(success), Some(message)) = (self.byte(), self.string()) else {
                return lost("success and message are missing");
            };
            if success == 0 && status.is_none() {
                return failure(message);
            }
            message.clone_into(&mut why);
            Record::new(ty)
        } else {
            match self.record(ty) {
                Ok(output) => output,
                Err(error) => return lost(&error.to_string()),
            }
        };
        match status {
            None | Some(SUCCEEDED) => Outcome::Success(output),
            Some(CANCELED) => {
                Outcome::Exception { name: INTERRUPTED.to_owned(), detail: Value::Null }
            }
            Some(_) => {
                if let Failure::Members(_, message) = manner.failure {
                    let told = ty.member_name(message).map(|name| output.to_json()[name].clone());
                    why = told.as_ref().and_then(Value::as_str).unwrap_or_default().to_owned();
                }
                failure(&why)
            }
        }
    }

    fn own_outcome(&mut self, ty: &DataType, status: Option<u8>) -> Outcome {
        let lost = |why: &str| Outcome::Lost(CallError::Serialization(why.to_owned()));
        let (Some(name), Some(detail)) = (self.string(), self.string()) else {
            return lost("exception and detail are missing");
        };
        let json = || match detail {
            "" => Ok(Value::Null),
            text => serde_json::from_str(text),
        };
        match (name, json()) {
            // A node of ROS that gives up need not know of exceptions.
            ("", _) if status == Some(ABORTED) => failure(""),
            ("", _) => match self.record(ty) {
                Ok(output) => Outcome::Success(output),
                Err(error) => lost(&error.to_string()),
            },
            (GONE, _) => Outcome::Lost(CallError::Gone),
            (SERIALIZATION, _) => lost(detail),
            (_, Ok(detail)) => Outcome::Exception { name: name.to_owned(), detail },
            (_, Err(error)) => lost(&error.to_string()),
        }
    }
}
