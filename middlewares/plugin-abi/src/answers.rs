//! What comes back for a request, as a structure of the table and as calls of [`Replies`].

use std::sync::{Mutex, PoisonError};

use genom_middleware::{ActivityId, CallError, Outcome, Replies};
use genom_types::{DataType, Record};
use serde_json::Value;

use crate::codes::{Code, Failure, Sides};
use crate::lent::{Bytes, Str, copied};
use crate::table::{Answer, what};

/// An answer that is owned here.
#[derive(Debug)]
pub enum Said {
    /// The activity was accepted.
    Accepted(ActivityId),
    /// It entered a state.
    State(String),
    /// The request ended.
    End(Outcome),
}

fn answer(what: u32, name: &str, data: &[u8]) -> Answer {
    let size = size_of::<Answer>();
    let (name, data) = (Str::of(name), Bytes::of(data));
    Answer { size, what, code: Code::OK, run: 0, value: 0, name, data }
}

impl Said {
    /// Passes it on as a structure that is lent.
    pub fn lend(self, to: impl FnOnce(&Answer)) {
        let mut message = Vec::new();
        let outcome = match self {
            Self::Accepted(id) => {
                return to(&Answer { run: id.0, ..answer(what::ACCEPTED, "", &[]) });
            }
            Self::State(name) => return to(&answer(what::STATE, &name, &[])),
            Self::End(Outcome::Success(output)) => match output.encode_message(&mut message) {
                Ok(()) => return to(&answer(what::RESULT, "", &message)),
                Err(error) => Outcome::Lost(CallError::Serialization(error.to_string())),
            },
            Self::End(other) => other,
        };
        match outcome {
            Outcome::Exception { name, detail } => {
                let text = if detail.is_null() { String::new() } else { detail.to_string() };
                to(&answer(what::EXCEPTION, &name, text.as_bytes()));
            }
            Outcome::Lost(error) => {
                let Failure { code, text, value } = error.into();
                to(&Answer { code, value, ..answer(what::LOST, &text, &[]) });
            }
            Outcome::Success(_) => {}
        }
    }

    /// Reads one. `None` if it is of no kind that is known here.
    ///
    /// # Safety
    /// It is an answer of the other side, lent for this call.
    #[must_use]
    pub unsafe fn read(answer: *const Answer, output: &DataType, sides: &Sides) -> Option<Self> {
        // SAFETY: an answer begins with its size; zero is a value of all its members.
        let answer = unsafe { copied(answer) }?;
        // SAFETY: both are lent for this call.
        let (name, data) = unsafe { (answer.name.read().into_owned(), answer.data.read()) };
        Some(match answer.what {
            what::ACCEPTED => Self::Accepted(ActivityId(answer.run)),
            what::STATE => Self::State(name),
            what::RESULT => {
                let mut record = Record::new(output);
                Self::End(match record.decode_message(data) {
                    Ok(()) => Outcome::Success(record),
                    Err(error) => Outcome::Lost(CallError::Serialization(error.to_string())),
                })
            }
            what::EXCEPTION if data.is_empty() => {
                Self::End(Outcome::Exception { name, detail: Value::Null })
            }
            what::EXCEPTION => Self::End(match serde_json::from_slice(data) {
                Ok(detail) => Outcome::Exception { name, detail },
                Err(error) => Outcome::Lost(CallError::Serialization(format!(
                    "the members of exception {name} are not JSON: {error}"
                ))),
            }),
            what::LOST => {
                let failure = Failure { code: answer.code, text: name, value: answer.value };
                Self::End(Outcome::Lost(failure.calling(sides)))
            }
            _ => return None,
        })
    }
}

/// Who waits for the answers to one request.
pub struct Waiting(Mutex<Option<Box<dyn Replies>>>);

impl Waiting {
    /// Somebody waits.
    #[must_use]
    pub fn new(replies: Box<dyn Replies>) -> Self {
        Self(Mutex::new(Some(replies)))
    }

    /// Passes an answer on. After an end nobody waits any more.
    pub fn tell(&self, said: Said) {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match said {
            Said::Accepted(id) => waiting.iter_mut().for_each(|one| one.accepted(id)),
            Said::State(name) => waiting.iter_mut().for_each(|one| one.feedback(&name)),
            Said::End(outcome) => {
                let replies = waiting.take();
                // It may run any code.
                drop(waiting);
                if let Some(replies) = replies {
                    replies.finish(outcome);
                }
            }
        }
    }
}
