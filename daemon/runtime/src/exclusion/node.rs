//! Special values in place of a node.

/// Runs nothing, and waits for nothing.
pub(super) const IDLE: u32 = u32::MAX;
/// Runs, or waits for, the exclusion of everything.
pub(super) const EVERYTHING: u32 = u32::MAX - 1;
/// Runs, or waits for, a standstill: the exclusion of everything, async nodes included.
pub(super) const STANDSTILL: u32 = u32::MAX - 2;

/// Whether this stands for more than one node.
pub(super) fn is_of_all(node: u32) -> bool {
    matches!(node, EVERYTHING | STANDSTILL)
}
