//! The ports of a component as recordings see them: tapes are put in and taken out.

use super::Hosted;

impl Hosted {
    /// Its ports are recorded, as far as they are wanted. Blocks while codels are excluded.
    pub fn record(&self) {
        if !self.recordings.any() {
            return;
        }
        let all = self.wires.tapes();
        let recorded = self.excluded(|| {
            for ((port, element), reads, tapes) in &all {
                let model = &self.model().ports[*port];
                let address = self.address(&model.name, element.as_deref());
                if let Some(ty) = self.port_type(*port) {
                    self.recordings.opened(&address, model.direction, reads.as_ref(), ty, tapes);
                }
            }
        });
        if let Err(error) = recorded {
            tracing::warn!("ports of {} are not recorded: {error}", self.name);
        }
    }

    /// A recording is over: its tapes are taken out. Blocks while codels are excluded.
    pub fn recording_ended(&self, number: u64) {
        let all = self.wires.tapes();
        if let Err(error) =
            self.excluded(|| all.iter().for_each(|(.., tapes)| tapes.remove(number)))
        {
            // Nobody empties them any more: they fill up, and are full.
            tracing::debug!("tapes of {} stay: {error}", self.name);
        }
    }
}
