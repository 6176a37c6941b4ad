//! Rules that differ from the runtime's in one point.

use genom_runtime::plan::Nodes;
use genom_timing::Conflicts;

/// One changed rule. Tests show that runs of the runtime are refused by each of these systems: so
/// the acceptance of those runs by the system itself says something about that rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variant {
    /// A free node is entered at once, even if another one that conflicts has waited for longer.
    UnfairLock,
    /// Stop requests are looked at on ticks only, and not between two ticks.
    StopOnTicks,
    /// An activity runs until it pauses before the next one of its task runs a codel.
    RunToPause,
    /// An end in one task does not wake the others.
    LostWakeUp,
    /// Ticks come at multiples of the period, without the delay of the task.
    Phase,
}

impl Variant {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::UnfairLock, Self::StopOnTicks, Self::RunToPause, Self::LostWakeUp, Self::Phase];
}

/// Which nodes of a plan exclude each other.
#[must_use]
pub fn conflicts(nodes: &Nodes, variant: Option<Variant>) -> Conflicts {
    let excludes =
        |node: usize| (0..nodes.len()).map(move |other| nodes.conflicts(node).contains(&other));
    let rows = (0..nodes.len()).map(|node| excludes(node).collect());
    Conflicts::new(rows.collect(), variant != Some(Variant::UnfairLock))
}
