//! Checks properties of a component.

use super::parts::Parts;
use super::verdict::{Property, Verdict};
use super::{answer, graph, order, untimed};
use crate::explore::{Explored, Limits};
use crate::ltl::Formula;
use crate::system::System;

/// Verdicts, and how they were found.
#[derive(Debug)]
pub struct Report {
    /// Each property that was asked for, in the order of [`Property::ALL`].
    pub verdicts: Vec<(Property, Verdict)>,
    /// Formulas of users.
    pub formulas: Vec<(Formula, Verdict)>,
    /// The states that were explored; `None` if no property needed that.
    pub explored: Option<Explored>,
}

impl System {
    /// Checks properties of the component.
    #[must_use]
    pub fn check(&self, properties: &[Property], limits: &Limits) -> Report {
        let asked = |property: &Property| properties.contains(property);
        let by_graph = |property: Property| match property {
            Property::Loop => Some(graph::loops(self)),
            Property::Stop => Some(graph::stops(self)),
            Property::Order => Some(order::order(self)),
            // With states of its own.
            Property::Answer => Some(answer::answer(self, limits)),
            Property::Start | Property::Stuck | Property::Reach | Property::Exclude => None,
        };
        let of_states = [Property::Start, Property::Stuck, Property::Reach, Property::Exclude];
        let explores = |property: &Property| asked(property) && of_states.contains(property);
        let all = Property::ALL;
        let some = all.iter().any(explores);
        let mut found = some.then(|| untimed::explore(self, &limits.first()));
        let large = found.as_ref().is_some_and(|found| found.explored.limit.is_some());
        let parts = large.then(|| Parts::new(self, limits));
        let by_parts = |property: Property| {
            let first = found.as_ref().map(|found| found.verdict(self, property));
            let decided = first.filter(|verdict| !matches!(verdict, Verdict::Undecided(_)));
            decided.or_else(|| parts.as_ref().and_then(|parts| parts.verdict(property)))
        };
        let known: Vec<(Property, Option<Verdict>)> =
            all.into_iter().filter(explores).map(|one| (one, by_parts(one))).collect();
        if large && known.iter().any(|(_, verdict)| verdict.is_none()) {
            // There is more to see.
            found = Some(untimed::explore(self, limits));
        }
        let verdict = |property: Property| {
            let untimed = || found.as_ref().map(|found| found.verdict(self, property));
            let known = known.iter().find(|(known, _)| *known == property);
            let known = known.and_then(|(_, verdict)| verdict.clone());
            by_graph(property).or(known).or_else(untimed).map(|verdict| (property, verdict))
        };
        let asked = Property::ALL.into_iter().filter(asked);
        let verdicts = asked.filter_map(verdict).collect();
        Report { verdicts, formulas: Vec::new(), explored: found.map(|found| found.explored) }
    }
}
