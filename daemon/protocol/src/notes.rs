//! What is recorded besides samples: the channels of calls, activities, exceptions and changes, and of
//! codels where each call is known.

use std::collections::BTreeMap;

use serde_json::json;

use crate::frames::Channel;

/// A channel of notes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoteKind {
    /// Requests of services, and replies.
    Calls,
    /// Activities: their starts, states and ends.
    Activities,
    /// Exceptions of services.
    Exceptions,
    /// Other changes, as `GET /events` tells them.
    Changes,
    /// Calls of codels: recordings of daemons have none, since each takes some 100 ns.
    Codels,
}

impl NoteKind {
    /// The kinds that daemons record, by channel number.
    pub const RECORDED: [Self; 4] =
        [Self::Calls, Self::Activities, Self::Exceptions, Self::Changes];

    /// Number of the channel.
    #[must_use]
    pub fn channel(self) -> u16 {
        self as u16
    }

    /// The head of the channel. Its encoding is JSON, since each service has other inputs.
    #[must_use]
    pub fn head(self) -> Channel {
        let (topic, name, members) = match self {
            Self::Calls => (
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
            Self::Activities => (
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
            Self::Exceptions => (
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
            Self::Changes => {
                ("/genom/changes", "genom.Change", json!({"event": {"type": "string"}}))
            }
            Self::Codels => (
                "/genom/codels",
                "genom.Codel",
                json!({
                    "event": {"enum": ["tick", "waits", "begins", "returns"]},
                    "component": {"type": "string"},
                    "task": {"type": "string"},
                    "owner": {"type": "string"},
                    "codel": {"type": "string"},
                    "behind": {"type": "array", "items": {"type": "string"}},
                    "yields": {"type": "string"},
                }),
            ),
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
