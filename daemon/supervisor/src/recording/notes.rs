//! Notes: what is recorded besides samples, such as calls, activities, exceptions and other
//! changes.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use genom_bus::Numbered;
pub(crate) use genom_protocol::NoteKind as Subject;

/// Maximum number of notes that wait to be sent.
const MOST: usize = 8192;

/// All subjects, by channel number.
pub(super) const SUBJECTS: [Subject; 4] = Subject::RECORDED;

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
