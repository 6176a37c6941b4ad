//! How the nodes of a graph name one another.

/// Index of a node in its graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Ix(pub(crate) u32);
