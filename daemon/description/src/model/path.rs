//! Ways into values.

/// One step into a value. Optionals met on the way are looked through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathStep {
    /// Member of a struct, union or exception, by index.
    Member(usize),
    /// Element of an array or sequence.
    Index(u32),
}
