//! A run as a recording, with the channels that `genomctl record` writes, and one for codels.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::Path;

use genom_formal::{Call, End, Event};
use genom_protocol::frames::{Sample, Start};
use genom_protocol::{ClockKind, NoteKind};
use genom_recording::{Recorder, WriteError};
use serde_json::{Value, json};

use super::Traced;

/// Why a run cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum Unrecorded {
    /// The file cannot be created.
    #[error(transparent)]
    File(io::Error),
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Writes a run; its dates are those of a stepped clock.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, run: &Traced<'_>) -> Result<(), Unrecorded> {
    let file = File::create(path).map_err(Unrecorded::File)?;
    let start = Start {
        recording: 1,
        genomd: env!("CARGO_PKG_VERSION").to_owned(),
        clock: ClockKind::Virtual,
        deployment: String::new(),
    };
    let mut recorder = Recorder::new("genomctl", path, file, &start)?;
    let kinds = || NoteKind::RECORDED.into_iter().chain([NoteKind::Codels]);
    for kind in kinds() {
        recorder.channel(kind.head())?;
    }
    let mut numbers: BTreeMap<u16, u32> = BTreeMap::new();
    for happening in &run.happenings {
        let Some((kind, note)) = note(run.told.subject.name(), &happening.event) else { continue };
        let number = numbers.entry(kind.channel()).or_default();
        let message = note.to_string();
        recorder.sample(&Sample {
            channel: kind.channel(),
            number: *number,
            date: happening.date,
            message: message.as_bytes(),
        })?;
        *number += 1;
    }
    recorder.finish(true)?;
    Ok(())
}

/// What is recorded of something that happens.
fn note(component: &str, event: &Event) -> Option<(NoteKind, Value)> {
    let codel = |event: &str, call: &Call| {
        json!({
            "event": event, "component": component, "task": call.task, "owner": call.owner,
            "codel": call.codel,
        })
    };
    Some(match event {
        Event::Tick(task) => {
            (NoteKind::Codels, json!({ "event": "tick", "component": component, "task": task }))
        }
        Event::Late(task) => {
            let note = json!({
                "event": "overrun", "component": component, "task": task, "ticks": 1,
            });
            (NoteKind::Changes, note)
        }
        Event::Begins(call) => (NoteKind::Codels, codel("begins", call)),
        Event::Waits(call, others) => {
            let mut note = codel("waits", call);
            note["behind"] = json!(others);
            (NoteKind::Codels, note)
        }
        Event::Returns(call, yields) => {
            let mut note = codel("returns", call);
            note["yields"] = json!(yields);
            (NoteKind::Codels, note)
        }
        Event::Request(service) => {
            let note = json!({
                "component": component, "service": service, "phase": "request", "inputs": {},
            });
            (NoteKind::Calls, note)
        }
        Event::Accepted(service, activity) => {
            let note = json!({
                "event": "activity_started", "component": component, "service": service,
                "activity": activity,
            });
            (NoteKind::Activities, note)
        }
        Event::Moved { service, activity, state, paused } => {
            let note = json!({
                "event": "transition", "component": component, "service": service,
                "activity": activity, "state": state, "paused": paused,
            });
            (NoteKind::Activities, note)
        }
        Event::Ended(service, activity, end) => {
            let mut note = json!({
                "event": "activity_ended", "component": component, "service": service,
                "activity": activity,
            });
            match end {
                End::Success => {}
                End::Interrupted => note["exception"] = "::genom::interrupted".into(),
                End::Failed => note["exception"] = "exception".into(),
            }
            (NoteKind::Activities, note)
        }
        Event::Fire(name) => {
            let note = json!({ "event": "event_fired", "component": component, "name": name });
            (NoteKind::Changes, note)
        }
        Event::Pass(_) | Event::Abort(_) | Event::Control => return None,
    })
}
