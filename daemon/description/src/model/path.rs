//! Paths into values.

/// One step of a path. An optional on the way takes no step: the path leads into its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathStep {
    /// Member of a struct, union or exception, by index.
    Member(usize),
    /// Element of an array or sequence.
    Index(u32),
}
