//! Special values in place of a node.

/// Runs nothing, and waits for nothing.
pub(super) const IDLE: u32 = u32::MAX;
/// Runs, or waits for, the exclusion of everything.
pub(super) const EVERYTHING: u32 = u32::MAX - 1;
