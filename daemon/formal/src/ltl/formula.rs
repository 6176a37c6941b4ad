//! Formulas of linear temporal logic.

use std::fmt;

use super::atom::Atom;

/// A formula about runs of a component, in linear temporal logic (`docs/verify.md`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    pub(crate) term: Term,
    pub(crate) text: String,
}

/// A formula, or a part of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Term {
    Const(bool),
    Atom(Atom),
    Not(Box<Term>),
    Two(Join, Box<Term>, Box<Term>),
    /// About what comes.
    Always(Box<Term>),
    Eventually(Box<Term>),
    Until(Box<Term>, Box<Term>),
    /// About what was.
    Once(Box<Term>),
    Historically(Box<Term>),
    Since(Box<Term>, Box<Term>),
    Previous(Box<Term>),
}

/// What joins two formulas without time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Join {
    And,
    Or,
    Implies,
    Equal,
}

impl Term {
    /// The parts of a formula.
    pub(crate) fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Const(_) | Self::Atom(_) => Vec::new(),
            Self::Not(a)
            | Self::Always(a)
            | Self::Eventually(a)
            | Self::Once(a)
            | Self::Historically(a)
            | Self::Previous(a) => vec![a],
            Self::Two(_, a, b) | Self::Until(a, b) | Self::Since(a, b) => vec![a, b],
        }
    }

    fn any(&self, wanted: &dyn Fn(&Self) -> bool) -> bool {
        wanted(self) || self.parts().into_iter().any(|part| part.any(wanted))
    }

    fn is_future(&self) -> bool {
        matches!(self, Self::Always(_) | Self::Eventually(_) | Self::Until(..))
    }

    fn is_past(&self) -> bool {
        matches!(self, Self::Once(_) | Self::Historically(_) | Self::Since(..) | Self::Previous(_))
    }
}

impl Formula {
    /// What must hold in every state, if the formula says no more than that: its truth in a state
    /// depends on what was before, and not on what comes.
    pub(crate) fn always(&self) -> Option<&Term> {
        match &self.term {
            Term::Always(body) if !body.any(&Term::is_future) => Some(body),
            _ => None,
        }
    }

    /// Whether genomctl checks it by itself: it is `[]` of a formula about the past.
    #[must_use]
    pub fn is_built_in(&self) -> bool {
        self.always().is_some()
    }

    /// Whether it speaks of what was.
    #[must_use]
    pub fn has_past(&self) -> bool {
        self.term.any(&Term::is_past)
    }

    /// Whether it speaks of ticks that come too soon.
    #[must_use]
    pub fn has_late(&self) -> bool {
        self.term.any(&|term| matches!(term, Term::Atom(Atom::Late(_))))
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
