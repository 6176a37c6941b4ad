//! What a context may run or wait for besides a node of the plan.

/// Runs nothing, waits for nothing.
pub(super) const IDLE: u32 = u32::MAX;
/// Everything at once, with all others kept out.
pub(super) const EVERYTHING: u32 = u32::MAX - 1;
