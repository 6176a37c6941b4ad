//! Orders: which events may follow which, as the steps of a small automaton.

use std::fmt;

use super::formula::{Atom, NoFormula, Parser, What};

/// Limit on the steps of an order.
pub const MOST_STEPS: usize = 64;

/// The steps of an automaton: events that its steps name may happen only where a step allows them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// The first one leaves the first state.
    pub steps: Vec<OrderStep>,
}

/// A step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderStep {
    /// The state that it leaves.
    pub from: String,
    /// What happens.
    pub event: Atom,
    /// The state that it leads to.
    pub to: String,
}

/// Why a list is no order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoOrder {
    /// A step is none.
    #[error("step {step} of `order`, {source}; a step is `STATE: EVENT -> STATE`")]
    Step {
        /// Its number, from 1.
        step: usize,
        /// What is wrong.
        source: NoFormula,
    },
    /// The automaton goes two ways, stays where it is, or lasts.
    #[error("step {step} of `order`: {why}")]
    Wrong {
        /// Its number, from 1.
        step: usize,
        /// What is wrong.
        why: String,
    },
    /// None, or too many.
    #[error("`order` has {0} steps, and is to have from 1 to {MOST_STEPS}")]
    Count(usize),
}

impl Order {
    /// Reads steps such as `homing: calibrate -> ready`.
    ///
    /// # Errors
    /// One is none, or is not like the others.
    pub fn read(steps: &[String]) -> Result<Self, NoOrder> {
        if steps.is_empty() || steps.len() > MOST_STEPS {
            return Err(NoOrder::Count(steps.len()));
        }
        let mut read: Vec<OrderStep> = Vec::new();
        for (text, number) in steps.iter().zip(1..) {
            let step = step(text).map_err(|source| NoOrder::Step { step: number, source })?;
            let wrong = |why: String| Err(NoOrder::Wrong { step: number, why });
            if step.event.what == Some(What::Run) {
                let name = &step.event.name;
                return wrong(format!("run({name}) lasts: say start({name}) or end({name})"));
            }
            let same = |other: &&OrderStep| {
                let (a, b) = (&other.event, &step.event);
                other.from == step.from && a.what == b.what && a.name == b.name
            };
            if let Some(other) = read.iter().find(same) {
                let OrderStep { from, event, .. } = other;
                return wrong(format!("{event} leads two ways from state {from}"));
            }
            read.push(step);
        }
        let first = read.first().map(|step| step.from.clone()).unwrap_or_default();
        for (step, number) in read.iter().zip(1..) {
            if step.from != first && !read.iter().any(|other| other.to == step.from) {
                let why = format!("no step leads to state {}", step.from);
                return Err(NoOrder::Wrong { step: number, why });
            }
        }
        Ok(Self { steps: read })
    }

    /// States in the order in which they are named.
    #[must_use]
    pub fn states(&self) -> Vec<&str> {
        let mut states: Vec<&str> = Vec::new();
        for step in &self.steps {
            for state in [step.from.as_str(), step.to.as_str()] {
                if !states.contains(&state) {
                    states.push(state);
                }
            }
        }
        states
    }
}

fn step(text: &str) -> Result<OrderStep, NoFormula> {
    let mut parser = Parser::new(text)?;
    let (from, _) = parser.word("a state")?;
    parser.wants(":")?;
    let event = parser.atom()?;
    parser.wants("->")?;
    let (to, _) = parser.word("a state")?;
    parser.ends()?;
    Ok(OrderStep { from, event, to })
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, OrderStep { from, event, to }) in self.steps.iter().enumerate() {
            let between = if at > 0 { ", " } else { "" };
            write!(f, "{between}{from}: {event} -> {to}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(steps: &[&str]) -> String {
        let steps: Vec<String> = steps.iter().map(|step| (*step).to_owned()).collect();
        Order::read(&steps).map_or_else(|why| why.to_string(), |order| order.to_string())
    }

    #[test]
    fn steps_are_read_and_what_is_none_is_refused() {
        assert_eq!(
            read(&["new: calibrate -> ready", "ready:start(move)->ready"]),
            "new: calibrate -> ready, ready: start(move) -> ready"
        );
        for (steps, why) in [
            (&[][..], "has 0 steps"),
            (&["a: b"], "step 1 of `order`, column 5: the end of the text stands where `->`"),
            (&["a: b -> c", "a: b -> d"], "step 2 of `order`: b leads two ways from state a"),
            (&["a: b -> c", "d: b -> c"], "step 2 of `order`: no step leads to state d"),
            (&["a: run(b) -> c"], "run(b) lasts: say start(b) or end(b)"),
            (&["a: b -> c d"], "column 11: `d` stands after the end"),
        ] {
            assert!(read(steps).contains(why), "{steps:?}: {}", read(steps));
        }
        assert!(read(&["a: b -> a"; 65]).contains("65 steps"));
    }
}
