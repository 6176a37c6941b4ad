//! The ports of a component as recordings see them: tapes are put in and taken out.

use super::Hosted;

impl Hosted {
    /// Its ports are recorded, as far as they are wanted. Blocks while codels are excluded.
    pub(crate) fn record(&self) {
        if !self.recordings.any() {
            return;
        }
        let all = self.wires.tapes();
        self.excluded(|| {
            for ((port, element), reads, tapes) in &all {
                let model = &self.model().ports[*port];
                let address = self.address(&model.name, element.as_deref());
                if let Some(ty) = self.port_type(*port) {
                    self.recordings.opened(&address, model.direction, reads.as_ref(), ty, tapes);
                }
            }
        });
    }

    /// A recording is over: its tapes are taken out. Blocks while codels are excluded.
    pub(crate) fn recording_ended(&self, number: u64) {
        let all = self.wires.tapes();
        self.excluded(|| all.iter().for_each(|(_, _, tapes)| tapes.remove(number)));
    }
}
