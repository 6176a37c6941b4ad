//! Layout of requests and responses.
//!
//! A request: length of the address, 4 bytes little endian; the address, such as `demo/goto`;
//! length and text of the service's digests as the caller knows them, in the same form; the input
//! as a CDR message.
//!
//! A response: one byte for its kind, then the content.
//! A response: a byte that says what it is, then that.
//!
//! | byte | rest |
//! |---|---|
//! | 1 accepted | activity id, 8 bytes little endian |
//! | 2 feedback | name of the state |
//! | 3 success | output as a CDR message |
//! | 4 exception | length of its name, 4 bytes little endian; its name; its detail as JSON |
//! | 5 refused | why the request could not be read |
//! | 6 not served | nothing: no such service here, or no more |
//! | 7 other types | types of the service as it is served |

use genom_middleware::{ActivityId, CallError, Outcome};
use genom_types::{CdrError, DataType, Record};

pub(super) fn accepted(id: ActivityId) -> Vec<u8> {
    with(1, &id.0.to_le_bytes())
}

pub(super) fn feedback(state: &str) -> Vec<u8> {
    with(2, state.as_bytes())
}

pub(super) fn refused(why: &str) -> Vec<u8> {
    with(5, why.as_bytes())
}

pub(super) fn not_served() -> Vec<u8> {
    vec![6]
}

pub(super) fn other_types(theirs: &str) -> Vec<u8> {
    with(7, theirs.as_bytes())
}

fn with(what: u8, rest: &[u8]) -> Vec<u8> {
    let mut frame = vec![what];
    frame.extend_from_slice(rest);
    frame
}

/// The last response to a request; `None` if dropping the request already says it all.
pub(super) fn finished(outcome: &Outcome) -> Option<Vec<u8>> {
    match outcome {
        Outcome::Success(output) => {
            let mut frame = vec![3];
            Some(match output.encode_message(&mut frame) {
                Ok(()) => frame,
                Err(error) => refused(&format!("its output cannot be encoded: {error}")),
            })
        }
        Outcome::Exception { name, detail } => {
            let mut frame = Vec::new();
            frame.push(4);
            put(&mut frame, name);
            frame.extend_from_slice(detail.to_string().as_bytes());
            Some(frame)
        }
        Outcome::Lost(CallError::Serialization(why)) => Some(refused(why)),
        Outcome::Lost(_) => None,
    }
}

/// The beginning of a request; the input is appended to it.
pub(super) fn request(address: &str, digests: &str) -> Vec<u8> {
    let mut frame = Vec::new();
    put(&mut frame, address);
    put(&mut frame, digests);
    frame
}

/// Splits a request into address, digests and input.
pub(super) fn read_request(frame: &[u8]) -> Option<(&str, &str, &[u8])> {
    let (address, rest) = take(frame)?;
    let (digests, input) = take(rest)?;
    Some((address, digests, input))
}

/// Appends a text with its length in front.
fn put(frame: &mut Vec<u8>, text: &str) {
    frame.extend_from_slice(&(text.len() as u32).to_le_bytes());
    frame.extend_from_slice(text.as_bytes());
}

fn take(frame: &[u8]) -> Option<(&str, &[u8])> {
    let (length, rest) = frame.split_first_chunk::<4>()?;
    let (text, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    Some((std::str::from_utf8(text).ok()?, rest))
}

/// A decoded response.
pub(super) enum Response {
    Accepted(ActivityId),
    Feedback(String),
    NotServed,
    OtherTypes(String),
    Finished(Outcome),
}

pub(super) fn read(frame: &[u8], output: &DataType) -> Response {
    parse(frame, output).unwrap_or_else(|error| {
        Response::Finished(Outcome::Lost(CallError::Serialization(error.to_string())))
    })
}

/// A frame cannot be decoded as a response.
#[derive(Debug, thiserror::Error)]
enum FrameError {
    #[error("it is empty")]
    Empty,
    #[error("an id has 8 bytes")]
    Id,
    #[error("it ends early")]
    Cut,
    #[error("{0} is no kind of response")]
    Kind(u8),
    #[error(transparent)]
    Text(#[from] std::str::Utf8Error),
    #[error(transparent)]
    Output(#[from] CdrError),
    #[error(transparent)]
    Detail(#[from] serde_json::Error),
    /// The other side could not read the request.
    #[error("{0}")]
    Refused(String),
}

fn parse(frame: &[u8], output: &DataType) -> Result<Response, FrameError> {
    let (what, rest) = frame.split_first().ok_or(FrameError::Empty)?;
    let text = |bytes: &[u8]| std::str::from_utf8(bytes).map(str::to_owned);
    Ok(match what {
        1 => {
            let id = rest.try_into().map_err(|_| FrameError::Id)?;
            Response::Accepted(ActivityId(u64::from_le_bytes(id)))
        }
        2 => Response::Feedback(text(rest)?),
        3 => {
            let mut value = Record::new(output);
            value.decode_message(rest)?;
            Response::Finished(Outcome::Success(value))
        }
        4 => {
            let (name, detail) = take(rest).ok_or(FrameError::Cut)?;
            let detail = serde_json::from_slice(detail)?;
            Response::Finished(Outcome::Exception { name: name.to_owned(), detail })
        }
        5 => return Err(FrameError::Refused(text(rest)?)),
        6 => Response::NotServed,
        7 => Response::OtherTypes(text(rest)?),
        other => return Err(FrameError::Kind(*other)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_as_written_and_none_is_read_from_less() {
        let mut frame = request("demo/goto", "activity 1f-2e");
        assert_eq!(read_request(&frame), Some(("demo/goto", "activity 1f-2e", &[][..])));
        let whole = frame.len();
        frame.extend_from_slice(&[7; 3]);
        assert_eq!(read_request(&frame).map(|(_, _, input)| input), Some(&[7; 3][..]));
        for end in 0..whole {
            assert_eq!(read_request(&frame[..end]), None, "of {end} bytes");
        }
        frame[..4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read_request(&frame), None);
    }
}
