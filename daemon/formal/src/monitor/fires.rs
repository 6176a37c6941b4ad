//! Whether a rule can be broken.

use crate::timed::Dated;
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
        run: Trace,
    },
    /// All that it is about breaks it: its bound or its order is wrong. With a run.
    Always {
        /// What happens at its end.
        what: String,
        /// The run.
        run: Trace,
    },
    /// Not decided, for this reason.
    Undecided(String),
}

/// A run that breaks a rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trace {
    /// Found without dates.
    Steps(Vec<Line>),
    /// With the earliest dates at which the rule is broken so; the last one is that of the violation.
    Dated(Vec<Dated>),
}

impl Trace {
    /// The lines, with their dates in nanoseconds from the start of the component if they have some.
    pub fn lines(&self) -> impl Iterator<Item = (Option<u64>, &Line)> {
        let (steps, dated) = match self {
            Self::Steps(lines) => (&lines[..], &[][..]),
            Self::Dated(lines) => (&[][..], &lines[..]),
        };
        let dated = dated.iter().map(|one| (Some(one.date), &one.line));
        steps.iter().map(|line| (None, line)).chain(dated)
    }
}

/// Not decided.
pub(super) fn undecided(why: &str) -> Fires {
    Fires::Undecided(why.to_owned())
}

/// What a search has found: what broke the rule first, and by which run, whether anything that the
/// rule is about did not break it, and the limit at which the search ended.
pub(super) fn concluded(
    broken: Option<(String, Trace)>,
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
