//! What a response holds: a byte that says what it is, then that.
//!
//! | byte | rest |
//! |---|---|
//! | 1 accepted | activity id, 8 bytes little endian |
//! | 2 feedback | name of the state |
//! | 3 success | output as a CDR message |
//! | 4 exception | length of its name, 4 bytes little endian; its name; its detail as JSON |
//! | 5 refused | why the request could not be read |

use genom_middleware::{ActivityId, CallError, Outcome};
use genom_types::{DataType, Record};

pub(super) fn accepted(id: ActivityId) -> Vec<u8> {
    with(1, &id.0.to_le_bytes())
}

pub(super) fn feedback(state: &str) -> Vec<u8> {
    with(2, state.as_bytes())
}

pub(super) fn refused(why: &str) -> Vec<u8> {
    with(5, why.as_bytes())
}

fn with(what: u8, rest: &[u8]) -> Vec<u8> {
    let mut frame = vec![what];
    frame.extend_from_slice(rest);
    frame
}

/// The end of a request; `None` when there is nothing to say but that it is over.
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
            let mut frame = with(4, &(name.len() as u32).to_le_bytes());
            frame.extend_from_slice(name.as_bytes());
            frame.extend_from_slice(detail.to_string().as_bytes());
            Some(frame)
        }
        Outcome::Lost(_) => None,
    }
}

/// A response, read.
pub(super) enum Response {
    Accepted(ActivityId),
    Feedback(String),
    Finished(Outcome),
}

pub(super) fn read(frame: &[u8], output: &DataType) -> Response {
    parse(frame, output)
        .unwrap_or_else(|why| Response::Finished(Outcome::Lost(CallError::Serialization(why))))
}

fn parse(frame: &[u8], output: &DataType) -> Result<Response, String> {
    let (what, rest) = frame.split_first().ok_or("it is empty")?;
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).map_err(|e| e.to_string());
    Ok(match what {
        1 => {
            let id = rest.try_into().map_err(|_| "an id has 8 bytes")?;
            Response::Accepted(ActivityId(u64::from_le_bytes(id)))
        }
        2 => Response::Feedback(text(rest)?),
        3 => {
            let mut value = Record::new(output);
            value.decode_message(rest).map_err(|error| error.to_string())?;
            Response::Finished(Outcome::Success(value))
        }
        4 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or("it ends early")?;
            let length = u32::from_le_bytes(*length) as usize;
            let (name, detail) = rest.split_at_checked(length).ok_or("it ends early")?;
            let detail = serde_json::from_slice(detail).map_err(|error| error.to_string())?;
            Response::Finished(Outcome::Exception { name: text(name)?, detail })
        }
        5 => return Err(text(rest)?),
        other => return Err(format!("{other} is no kind of response")),
    })
}
