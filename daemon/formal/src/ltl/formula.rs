//! Formulas of linear temporal logic.

use std::fmt;

use super::atom::Atom;
use crate::state::State;
use crate::system::System;

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

static TRUE: Term = Term::Const(true);

/// Of a formula that something comes: what, and when it must.
pub(crate) struct Comes<'f> {
    pub(crate) goal: &'f Term,
    /// From each state in which this holds; from the first one, if it is none.
    pub(crate) whenever: Option<&'f Term>,
}

/// What joins two formulas without time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Join {
    And,
    Or,
    Implies,
    Equal,
}

impl Join {
    pub(crate) fn of(self, a: bool, b: bool) -> bool {
        match self {
            Self::And => a && b,
            Self::Or => a || b,
            Self::Implies => !a || b,
            Self::Equal => a == b,
        }
    }
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

    /// Whether it is about one state.
    fn is_now(&self) -> bool {
        !self.any(&|term| term.is_future() || term.is_past())
    }

    /// Whether it holds in a state, if it is about one.
    pub(crate) fn holds_in(&self, system: &System, state: &State) -> bool {
        let one = |part: &Self| part.holds_in(system, state);
        match self {
            Self::Const(value) => *value,
            Self::Atom(atom) => atom.holds(system, state),
            Self::Not(a) => !one(a),
            Self::Two(join, a, b) => join.of(one(a), one(b)),
            _ => false,
        }
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

    /// What comes, if the formula says no more than that.
    pub(crate) fn comes(&self) -> Option<Comes<'_>> {
        let comes = match &self.term {
            Term::Eventually(goal) => Comes { goal, whenever: None },
            Term::Always(body) => match &**body {
                Term::Eventually(goal) => Comes { goal, whenever: Some(&TRUE) },
                Term::Two(Join::Implies, when, then) => match &**then {
                    Term::Eventually(goal) => Comes { goal, whenever: Some(when) },
                    _ => return None,
                },
                _ => return None,
            },
            _ => return None,
        };
        let now = comes.goal.is_now() && comes.whenever.is_none_or(Term::is_now);
        now.then_some(comes)
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
