//! Notes: what is recorded besides samples, such as calls, activities, exceptions and other
//! changes.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};

use genom_protocol::frames::Channel;
use serde_json::{Value, json};

use genom_bus::Numbered;

/// Maximum number of notes that wait to be sent.
const MOST: usize = 8192;

/// A channel of notes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    Calls,
    Activities,
    Exceptions,
    Changes,
}

/// All subjects, by channel number.
pub(super) const SUBJECTS: [Subject; 4] =
    [Subject::Calls, Subject::Activities, Subject::Exceptions, Subject::Changes];

impl Subject {
    pub(super) fn channel(self) -> u16 {
        self as u16
    }

    /// The head of the channel. Its encoding is JSON, since each service has other inputs.
    pub(super) fn head(self) -> Channel {
        let (topic, name, members) = match self {
            Subject::Calls => (
                "/genom/calls",
                "genom.Call",
                json!({
                    "component": {"type": "string"},
                    "service": {"type": "string"},
                    "call": {"type": "integer", "description": "the same in request and reply"},
                    "phase": {"enum": ["request", "reply"]},
                    "inputs": {"type": "object"},
                    "activity": {"type": "integer"},
                    "result": {"type": "object"},
                    "exception": {"type": "string"},
                    "detail": {},
                    "duration_ns": {"type": "integer"},
                }),
            ),
            Subject::Activities => (
                "/genom/activities",
                "genom.Activity",
                json!({
                    "event": {"enum": ["activity_started", "transition", "activity_ended"]},
                    "component": {"type": "string"},
                    "service": {"type": "string"},
                    "activity": {"type": "integer"},
                    "state": {"type": "string"},
                    "paused": {"type": "boolean"},
                    "exception": {"type": "string"},
                }),
            ),
            Subject::Exceptions => (
                "/genom/exceptions",
                "genom.Exception",
                json!({
                    "component": {"type": "string"},
                    "service": {"type": "string"},
                    "activity": {"type": "integer"},
                    "exception": {"type": "string"},
                    "detail": {},
                }),
            ),
            Subject::Changes => {
                ("/genom/changes", "genom.Change", json!({"event": {"type": "string"}}))
            }
        };
        Channel {
            channel: self.channel(),
            topic: topic.to_owned(),
            encoding: "json".to_owned(),
            schema: name.to_owned(),
            definition: json!({"type": "object", "properties": members}).to_string(),
            metadata: BTreeMap::new(),
        }
    }
}

/// The subject of a change, and the component it concerns, if any.
pub(super) fn subject(change: &Numbered) -> (Subject, Option<&str>) {
    let text = |key: &str| change.data.get(key).and_then(Value::as_str);
    let on = match text("event") {
        Some("activity_started" | "transition" | "activity_ended") => Subject::Activities,
        _ => Subject::Changes,
    };
    (on, text("component"))
}

/// A note that waits to be sent.
pub(super) struct Note {
    pub(super) subject: Subject,
    pub(super) number: u32,
    pub(super) moment: u64,
    pub(super) text: String,
}

/// The notes of one recording that wait to be sent.
#[derive(Default)]
pub(super) struct Notes(Mutex<State>);

#[derive(Default)]
struct State {
    waiting: VecDeque<Note>,
    numbers: [u32; SUBJECTS.len()],
    lost: [u64; SUBJECTS.len()],
}

impl Notes {
    pub(super) fn add(&self, subject: Subject, moment: u64, content: &Value) {
        let text = content.to_string();
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = usize::from(subject.channel());
        let number = state.numbers[at];
        state.numbers[at] = number.wrapping_add(1);
        if state.waiting.len() < MOST {
            state.waiting.push_back(Note { subject, number, moment, text });
        } else {
            state.lost[at] += 1;
        }
    }

    /// Counts `count` notes that were lost elsewhere.
    pub(super) fn lose(&self, subject: Subject, count: u64) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.lost[usize::from(subject.channel())] += count;
    }

    /// Takes all notes that wait, and the total lost so far for each subject.
    pub(super) fn take(&self) -> (VecDeque<Note>, [u64; SUBJECTS.len()]) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        (std::mem::take(&mut state.waiting), state.lost)
    }
}
