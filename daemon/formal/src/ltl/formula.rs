//! Formulas of linear temporal logic.

use std::fmt;

use genom_temporal::{FormulaError, Join, NoFact, parse};

use super::atom::Atom;
use crate::state::State;
use crate::system::System;

/// A formula about runs of a component, in linear temporal logic (`docs/verify.md`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    pub(crate) term: Term,
    pub(crate) text: String,
}

/// A formula about a component, or a part of one.
pub type Term = genom_temporal::Term<Atom>;

/// What formulas are about.
const FACTS: &str = "codel(NAME), run(SERVICE), pending(SERVICE), late(TASK) or a service";

static TRUE: Term = Term::Const(true);

/// Of a formula that something comes: what, and when it must.
pub(crate) struct Comes<'f> {
    pub(crate) goal: &'f Term,
    /// From each state in which this holds; from the first one, if it is none.
    pub(crate) whenever: Option<&'f Term>,
}

/// Whether it holds in a state, if it is about one.
pub(crate) fn holds_in(term: &Term, system: &System, state: &State) -> bool {
    term.holds(&|atom| atom.holds(system, state))
}

impl Formula {
    /// The formula that a text says about a component.
    ///
    /// # Errors
    /// If the text is none, or names what the component does not have.
    pub fn new(system: &System, text: &str) -> Result<Self, FormulaError> {
        let fact = |fact: Option<&str>, name: &str| {
            Atom::named(system, fact.unwrap_or("run"), name).map_err(|why| NoFact(why.to_string()))
        };
        Ok(Self { term: parse(text, FACTS, &fact)?, text: text.to_owned() })
    }

    /// What it says.
    #[must_use]
    pub fn term(&self) -> &Term {
        &self.term
    }

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
