//! Whether a rule can be broken.

use crate::words::Line;

/// Whether a rule can be broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fires {
    /// No run breaks it.
    Never,
    /// This run does; none is shorter in steps.
    Can {
        /// What happens at its end.
        what: String,
        /// The run.
        run: Vec<Line>,
    },
    /// All that it is about breaks it: its bound or its order is wrong. With a run.
    Always {
        /// What happens at its end.
        what: String,
        /// The run.
        run: Vec<Line>,
    },
    /// Not decided, for this reason.
    Undecided(String),
}

/// Not decided.
pub(super) fn undecided(why: &str) -> Fires {
    Fires::Undecided(why.to_owned())
}
