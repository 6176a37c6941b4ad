//! Index by which the nodes of a graph refer to each other.

/// Index of a node in its graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Ix(pub(crate) u32);
