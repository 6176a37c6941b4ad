//! Whether a rule can be broken.

use crate::words::Line;
use genom_timing::Limit;

/// Whether a rule can be broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fires {
    /// No run breaks it.
    Never,
    /// This run does. Without bounds in the rule, none is shorter in steps.
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

/// What a search has found: what broke the rule first, and by which run, whether anything that the
/// rule is about did not break it, and the limit at which the search ended.
pub(super) fn concluded(
    broken: Option<(String, Vec<Line>)>,
    kept: bool,
    limit: Option<Limit>,
) -> Fires {
    match (broken, limit) {
        (Some((what, run)), limit) if kept || limit.is_some() => Fires::Can { what, run },
        (Some((what, run)), _) => Fires::Always { what, run },
        (None, Some(limit)) => {
            Fires::Undecided(format!("{limit}: raise the limits, or lower the bounds"))
        }
        (None, None) => Fires::Never,
    }
}
