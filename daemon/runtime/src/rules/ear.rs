//! What hears something that happens.

use genom_monitor::{Letter, Pulse};

/// What hears something that happens, by index.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ear {
    /// A heartbeat.
    Beat(u16, Pulse),
    /// An order, and the number of its event.
    Order(u16, u16),
}

/// A formula that hears something that happens, by index, and what is done about that.
#[derive(Clone, Debug)]
pub(super) struct Judges {
    pub(super) at: u16,
    pub(super) letter: Letter,
}
