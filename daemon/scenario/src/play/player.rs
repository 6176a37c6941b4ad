//! What is known of a scenario while it is played.

use std::collections::BTreeMap;

use super::pace::Pace;
use super::relay::Relay;

/// An activity that a step started.
#[derive(Clone, Debug)]
pub(super) struct Started {
    pub(super) component: String,
    /// Its number in the component.
    pub(super) number: u64,
    /// When it was accepted, in nanoseconds.
    pub(super) at: u64,
    /// Whether it ended with the process of its cell.
    pub(super) gone: bool,
}

/// A scenario that is being played.
pub(super) struct Player<'d, D> {
    pub(super) daemon: &'d D,
    /// The time on the clock, in nanoseconds.
    pub(super) now: u64,
    /// Activities by what steps call them; the latest of a name.
    pub(super) started: BTreeMap<String, Started>,
    /// Faults of connections.
    pub(super) relays: Vec<Relay>,
    /// The shortest period of all tasks, and whether there are cells; unknown after something was
    /// loaded.
    pub(super) pace: Option<Pace>,
}

impl<'d, D> Player<'d, D> {
    /// Nothing was done yet.
    pub(super) fn new(daemon: &'d D) -> Self {
        Self { daemon, now: 0, started: BTreeMap::new(), relays: Vec::new(), pace: None }
    }
}
