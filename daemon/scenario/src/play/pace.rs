//! In what slices the clock is stepped.

/// How the clock is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pace {
    /// The shortest period of all tasks, in nanoseconds; `None` if none has one.
    pub(super) period: Option<u64>,
    /// Whether a component is in a cell. The daemon steps processes one after the other: within a
    /// period, so that none of them runs ahead.
    pub(super) cells: bool,
}
