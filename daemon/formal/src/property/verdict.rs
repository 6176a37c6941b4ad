//! What is checked, and what was found.

use genom_description::model::Span;

use crate::words::Line;

/// A property that is checked (`docs/verify.md`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// The start-up comes to its end.
    Start,
    /// There is always a next step until everything has ended.
    Stuck,
    /// Every codel and every service can run.
    Reach,
    /// No cycle ends never because states follow each other without pause.
    Loop,
    /// An activity that was asked to stop does not sleep.
    Stop,
    /// `before` and `after` leave an order in which each service can run.
    Order,
    /// What excludes each other is never executed at the same time.
    Exclude,
    /// Every request is answered.
    Answer,
}

impl Property {
    /// All of them, as they are reported.
    pub const ALL: [Self; 8] = [
        Self::Start,
        Self::Stuck,
        Self::Reach,
        Self::Loop,
        Self::Stop,
        Self::Order,
        Self::Exclude,
        Self::Answer,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Stuck => "stuck",
            Self::Reach => "reach",
            Self::Loop => "loop",
            Self::Stop => "stop",
            Self::Order => "order",
            Self::Exclude => "exclude",
            Self::Answer => "answer",
        }
    }
}

/// Whether a property holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// In all states, within the bounds.
    Holds,
    /// It does not: what was found.
    Violated(Vec<Finding>),
    /// Not decided, and why.
    Undecided(String),
}

/// Something that violates a property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What is wrong, in a sentence.
    pub what: String,
    /// Where that is declared.
    pub span: Option<Span>,
    /// A shortest run that shows it; empty where no run is needed.
    pub run: Vec<Line>,
}

/// Holds if nothing was found.
pub(super) fn verdict(found: Vec<Finding>) -> Verdict {
    if found.is_empty() { Verdict::Holds } else { Verdict::Violated(found) }
}
