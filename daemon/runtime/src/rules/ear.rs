//! What hears something that happens.

use super::beat::Pulse;

/// What hears something that happens, by index.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ear {
    /// A heartbeat.
    Beat(u16, Pulse),
    /// An order, and the number of its event.
    Order(u16, u16),
    /// A formula of the task in whose thread this happens, and the number under which it hears.
    Own(u16, u16),
    /// A formula that several threads move on, and that number.
    Shared(u16, u16),
}
