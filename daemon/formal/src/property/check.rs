//! Checks properties of a component.

use super::parts::Parts;
use super::verdict::{Property, Verdict};
use super::{answer, graph, order, untimed};
use crate::explore::Looked;
use crate::ltl::Formula;
use crate::system::System;
use genom_timing::Limits;

/// Verdicts, and how they were found.
#[derive(Debug)]
pub struct Report {
    /// Each property that was asked for, in the order of [`Property::ALL`].
    pub verdicts: Vec<(Property, Verdict)>,
    /// Formulas of users.
    pub formulas: Vec<(Formula, Verdict)>,
    /// How many states were explored; `None` if no property needed that.
    pub explored: Option<Looked>,
}

/// What is looked for in all states.
const OF_STATES: [Property; 4] =
    [Property::Start, Property::Stuck, Property::Reach, Property::Exclude];

impl System {
    /// Checks properties of the component.
    #[must_use]
    pub fn check(&self, properties: &[Property], limits: &Limits) -> Report {
        let asked = |property: &Property| properties.contains(property);
        let of_states: Vec<Property> = OF_STATES.into_iter().filter(asked).collect();
        let (known, explored) = if of_states.is_empty() {
            (Vec::new(), None)
        } else {
            let (known, looked) = self.check_states(&of_states, limits);
            (known, Some(looked))
        };
        let large = explored.is_some_and(|(_, large)| large);
        let verdict = |property: Property| match property {
            Property::Loop => Some(graph::loops(self)),
            Property::Stop => Some(graph::stops(self)),
            Property::Order => Some(order::order(self)),
            // With states of its own.
            Property::Answer => Some(answer::answer(self, limits, large)),
            Property::Start | Property::Stuck | Property::Reach | Property::Exclude => {
                let known = known.iter().find(|(known, _)| *known == property);
                known.map(|(_, verdict)| verdict.clone())
            }
        };
        let asked = Property::ALL.into_iter().filter(asked);
        let verdicts = asked.filter_map(|one| Some((one, verdict(one)?))).collect();
        let explored = explored.map(|(looked, _)| looked);
        Report { verdicts, formulas: Vec::new(), explored }
    }

    /// Verdicts on what is looked for in all states; how many were seen, and whether a first look did
    /// not see all. States are forgotten before others are looked at.
    fn check_states(
        &self,
        properties: &[Property],
        limits: &Limits,
    ) -> (Vec<(Property, Verdict)>, (Looked, bool)) {
        let verdicts = |limits: &Limits| {
            let found = untimed::explore(self, limits);
            let verdict = |one: &Property| (*one, found.verdict(self, *one));
            let all: Vec<(Property, Verdict)> = properties.iter().map(verdict).collect();
            (all, found.explored.looked())
        };
        let (mut known, mut looked) = verdicts(&limits.first());
        let large = looked.limit.is_some();
        let is_open = |verdict: &Verdict| matches!(verdict, Verdict::Undecided(_));
        if large {
            let parts = Parts::new(self, limits);
            for (property, verdict) in known.iter_mut().filter(|(_, verdict)| is_open(verdict)) {
                if let Some(decided) = parts.verdict(*property) {
                    *verdict = decided;
                }
            }
        }
        if known.iter().any(|(_, verdict)| is_open(verdict)) {
            // There is more to see.
            let (all, more) = verdicts(limits);
            for ((_, verdict), (_, seen)) in known.iter_mut().zip(all) {
                if is_open(verdict) {
                    *verdict = seen;
                }
            }
            looked = more;
        }
        (known, (looked, large))
    }
}
