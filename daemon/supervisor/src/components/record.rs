//! Attaches tapes of recordings to the ports of a component, and removes them.

use genom_protocol::frames::Channel;

use super::hosted::Hosted;
use crate::recording::{Watch, heads};

impl Hosted {
    /// Attaches tapes of the running recordings to the ports that they want. Blocks while codels
    /// are excluded.
    pub fn record(&self) {
        if !self.recordings.any() {
            return;
        }
        let all = self.ties.tapes();
        let recorded = self.excluded(|| {
            for (key, reads, tapes) in &all {
                let direction = self.model().ports[key.port].direction;
                if let Some(ty) = self.port_type(key.port) {
                    let address = self.port_address(key);
                    self.recordings.opened(&address, direction, reads.as_ref(), ty, tapes);
                }
            }
        });
        if let Err(error) = recorded {
            tracing::warn!("ports of {} are not recorded: {error}", self.name);
        }
    }

    /// The channels that a recording of its ports would have now, without numbers.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        let all = self.ties.tapes().into_iter().filter_map(|(key, reads, _)| {
            let direction = self.model().ports[key.port].direction;
            let ty = self.port_type(key.port)?;
            heads::of_port(&self.port_address(&key), direction, reads.as_ref(), ty)
        });
        all.collect()
    }

    /// Attaches tapes of a watch to the ports that it wants. Blocks while codels are excluded, which
    /// takes no longer than a few assignments.
    pub(crate) fn watch(&self, watch: &Watch) {
        let open = self.ties.tapes().into_iter();
        let made: Vec<_> = open
            .filter_map(|(key, _, tapes)| {
                let direction = self.model().ports[key.port].direction;
                let ty = self.port_type(key.port)?;
                let address = self.port_address(&key);
                let tape = self.recordings.tape_of(watch, &address, direction, ty)?;
                Some((tapes, tape))
            })
            .collect();
        if made.is_empty() {
            return;
        }
        let attached = self.excluded(|| {
            for (tapes, tape) in made {
                tapes.add(watch.number(), || tape);
            }
        });
        if let Err(error) = attached {
            tracing::warn!("ports of {} are not plotted: {error}", self.name);
        }
    }

    /// Removes the tapes of a recording that ended. Blocks while codels are excluded.
    pub fn recording_ended(&self, number: u64) {
        let all = self.ties.tapes();
        if let Err(error) =
            self.excluded(|| all.iter().for_each(|(.., tapes)| tapes.remove(number)))
        {
            // They stay attached, and drop samples once they are full.
            tracing::debug!("tapes of {} stay: {error}", self.name);
        }
    }
}
