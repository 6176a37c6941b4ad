//! Participants whose lease expired and that are back: the network was down, or one side was
//! suspended.
//!
//! RustDDS keeps what it knew of the ends of such a participant. When it hears of the participant
//! again, it does not match them with ours: it does so only when they are announced, and it
//! processes each announcement once. It matches all ends of a topic again when an end is added
//! here, so a temporary end is added for each topic that both sides use.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::dds::rustdds::{GUID, RTPSEntity};

use crate::dds::graph::Found;
use crate::dds::participant::{Dds, Direction};
use crate::dds::wire::{self, Reader, Writer};

/// Number of absent participants that are remembered.
const MANY: usize = 256;

/// A temporary end that was not matched within this time is dropped.
const LONGEST: Duration = Duration::from_secs(5);

enum Moment {
    Writer(#[allow(dead_code, reason = "to be there is what it does")] Box<Writer>),
    Reader(#[allow(dead_code, reason = "to be there is what it does")] Box<Reader>),
}

/// The absent participants, and the temporary ends.
pub(crate) struct Reunions {
    dds: Arc<Dds>,
    away: HashMap<Vec<u8>, HashSet<(String, Direction)>>,
    moments: HashMap<GUID, (Moment, Instant)>,
}

impl Reunions {
    pub(crate) fn new(dds: Arc<Dds>) -> Self {
        Self { dds, away: HashMap::new(), moments: HashMap::new() }
    }

    /// A participant with these ends is gone; `silent` if its lease expired, false if it announced
    /// that it leaves.
    pub(crate) fn lost(&mut self, id: impl AsRef<[u8]>, ends: Vec<Found>, silent: bool) {
        if !silent || (self.away.len() >= MANY && !self.away.contains_key(id.as_ref())) {
            self.away.remove(id.as_ref());
            return;
        }
        // Our ends are the opposite ones.
        let ours = |found: Found| {
            let direction = if found.writer { Direction::Reads } else { Direction::Writes };
            (found.topic, direction)
        };
        self.away.insert(id.as_ref().to_vec(), ends.into_iter().map(ours).collect());
    }

    /// A participant appeared, perhaps not for the first time.
    pub(crate) fn found(&mut self, id: impl AsRef<[u8]>) {
        self.moments.retain(|_, (_, since)| since.elapsed() < LONGEST);
        let Some(ends) = self.away.remove(id.as_ref()) else { return };
        let mut topics = 0;
        for (topic, direction) in ends {
            let Some((ty, qos)) = self.dds.opened(&topic, direction) else { continue };
            let moment = match direction {
                Direction::Writes => self
                    .dds
                    .writer(&topic, &ty, &qos)
                    .map(|writer| (writer.guid(), Moment::Writer(Box::new(writer)))),
                // It requests the weakest QoS, so that it matches all writers.
                Direction::Reads => {
                    let qos = wire::qos(false, false, 1);
                    self.dds
                        .moment(&topic, &ty, &qos)
                        .map(|reader| (reader.guid(), Moment::Reader(Box::new(reader))))
                }
            };
            match moment {
                Ok((guid, moment)) => {
                    self.moments.insert(guid, (moment, Instant::now()));
                    topics += 1;
                }
                Err(why) => tracing::warn!(%topic, %why, "an end that came back is not met"),
            }
        }
        tracing::info!(topics, "a participant is back that was silent for too long");
    }

    /// RustDDS has matched an end of ours. Returns whether it was a temporary one, which is
    /// dropped.
    pub(crate) fn matched(&mut self, end: GUID) -> bool {
        self.moments.remove(&end).is_some()
    }
}
