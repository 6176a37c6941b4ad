//! What activities did, with the times at which they did it, from the black box of the daemon.

use std::collections::BTreeSet;

use genom_protocol::frames::{Frame, NoFrame};
use serde::Deserialize;

/// The subject of the black box that has activities.
const TOPIC: &str = "/genom/activities";

/// Something that an activity did.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
struct Message {
    event: String,
    component: String,
    activity: u64,
    #[serde(default)]
    state: String,
}

/// What an activity did so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Life {
    /// When it started and ended, in nanoseconds.
    pub(super) started: Option<u64>,
    pub(super) ended: Option<u64>,
    /// States that it entered; one that follows itself is there once.
    pub(super) states: Vec<String>,
}

impl Life {
    /// Reads what the black box keeps of an activity.
    ///
    /// # Errors
    /// The bytes are not frames.
    pub(super) fn read(bytes: &[u8], component: &str, activity: u64) -> Result<Self, NoFrame> {
        let mut channels = BTreeSet::new();
        let mut life = Self::default();
        let mut rest = bytes;
        while let Some((frame, length)) = Frame::first(rest)? {
            rest = rest.get(length..).unwrap_or_default();
            match frame {
                Frame::Channel(channel) if channel.topic == TOPIC => {
                    channels.insert(channel.channel);
                }
                Frame::Sample(sample) if channels.contains(&sample.channel) => {
                    let Ok(message) = serde_json::from_slice::<Message>(sample.message) else {
                        continue;
                    };
                    if message.component == component && message.activity == activity {
                        life.add(sample.date, message);
                    }
                }
                _ => {}
            }
        }
        Ok(life)
    }

    fn add(&mut self, date: u64, Message { event, state, .. }: Message) {
        match event.as_str() {
            "activity_started" => self.started = Some(date),
            "activity_ended" => self.ended = Some(date),
            "transition" if self.states.last() != Some(&state) => self.states.push(state),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use genom_protocol::frames::{Channel, Sample};
    use serde_json::json;

    use super::*;

    #[test]
    fn an_activity_is_found_among_others_with_its_times_and_states() {
        let mut bytes = Vec::new();
        for (number, topic) in [(0, "/genom/calls"), (1, TOPIC)] {
            let channel = Channel {
                channel: number,
                topic: topic.to_owned(),
                encoding: "json".to_owned(),
                schema: String::new(),
                definition: String::new(),
                metadata: BTreeMap::new(),
            };
            Frame::Channel(channel).append(&mut bytes);
        }
        let mut add = |channel, date, message: serde_json::Value| {
            let message = message.to_string();
            let message = message.as_bytes();
            Frame::Sample(Sample { channel, number: 0, date, message }).append(&mut bytes);
        };
        let moved = |activity: u64, state: &str| {
            json!({"event": "transition", "component": "arm", "activity": activity,
                   "service": "go", "state": state, "paused": true})
        };
        add(1, 5, json!({"event": "activity_started", "component": "arm", "activity": 2}));
        add(1, 5, moved(2, "start"));
        add(1, 6, moved(3, "elsewhere"));
        add(0, 6, moved(2, "a call"));
        add(1, 7, moved(2, "start"));
        add(1, 9, moved(2, "stop"));
        add(1, 9, moved(2, "start"));
        add(1, 11, json!({"event": "activity_ended", "component": "arm", "activity": 2}));
        let life = Life::read(&bytes, "arm", 2).unwrap();
        assert_eq!((life.started, life.ended), (Some(5), Some(11)));
        assert_eq!(life.states, ["start", "stop", "start"]);
        assert_eq!(Life::read(&bytes, "leg", 2).unwrap(), Life::default());
        assert!(Life::read(&[0, 0, 0, 0], "arm", 2).is_err());
    }
}
