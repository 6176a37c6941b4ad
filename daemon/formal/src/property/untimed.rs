//! Properties that all reachable states are looked at for.

use genom_description::model::{CodelIx, Ix as _};

use super::seen::Seen;
use super::verdict::{Finding, Property, Verdict, verdict};
use crate::action::Action;
use crate::explore::Explored;
use crate::state::{Phase, State};
use crate::system::System;
use crate::words::Line;
use genom_timing::Limits;

/// What was seen of the states.
pub(super) struct Found {
    pub(super) explored: Explored,
    /// The first state in which nothing is possible although not everything has ended.
    stuck: Option<u32>,
    /// The first state in which two nodes are executed that exclude each other.
    together: Option<(u32, u16, u16)>,
    seen: Seen,
}

/// Explores the system, and keeps what properties ask for.
pub(super) fn explore(system: &System, limits: &Limits) -> Found {
    let (mut stuck, mut together, mut seen) = (None, None, Seen::new(system));
    let explored = Explored::new(system, limits, |number, state, enabled: &[Action]| {
        if is_stuck(state, enabled) {
            stuck.get_or_insert(number);
        }
        seen.note(state);
        let held: Vec<(u16, u16)> = state.lock.holders().collect();
        for (at, (_, node)) in held.iter().enumerate() {
            let others = &held[at + 1..];
            if let Some((_, other)) =
                others.iter().find(|(_, o)| system.conflicts.between(*node, *o))
            {
                together.get_or_insert((number, *node, *other));
            }
        }
    });
    Found { explored, stuck, together, seen }
}

/// Whether nothing is possible although not everything has ended. While a component runs it may wait
/// for requests, which the bounds may exclude.
pub(super) fn is_stuck(state: &State, enabled: &[Action]) -> bool {
    enabled.is_empty() && !matches!(state.phase, Phase::Stopped | Phase::Running)
}

impl Found {
    /// Whether a property holds.
    pub(super) fn verdict(&self, system: &System, property: Property) -> Verdict {
        let found = match property {
            Property::Start => self.start(system),
            Property::Stuck => self.stuck(system),
            Property::Reach => self.reach(system),
            Property::Exclude => self.exclude(system),
            Property::Loop | Property::Stop | Property::Order | Property::Answer => Vec::new(),
        };
        // A run that shows a violation is one whether all states were seen or not. What was not
        // seen yet may still be reached.
        let shown = found.iter().any(|found| !found.run.is_empty());
        match self.explored.limit {
            Some(limit) if !shown => {
                Verdict::Undecided(format!("{limit}: raise the limits, or lower the bounds"))
            }
            _ => verdict(found),
        }
    }

    fn start(&self, system: &System) -> Vec<Finding> {
        if self.seen.runs {
            return Vec::new();
        }
        let what = "no run of the start codels leads to a component that serves requests".into();
        let span = Some(system.plan.component().span);
        vec![Finding { what, span, run: Vec::new() }]
    }

    fn stuck(&self, system: &System) -> Vec<Finding> {
        self.stuck.map(|number| stuck(&self.explored, system, number)).into_iter().collect()
    }

    fn exclude(&self, system: &System) -> Vec<Finding> {
        let Some((number, a, b)) = self.together else { return Vec::new() };
        let name = |node: u16| system.node_name(node);
        let what = format!("{} and {} are executed at the same time", name(a), name(b));
        vec![Finding { what, span: None, run: lines(&self.explored, system, number) }]
    }

    fn reach(&self, system: &System) -> Vec<Finding> {
        self.seen.missing(system)
    }
}

/// A state in which nothing is possible.
pub(super) fn stuck(explored: &Explored, system: &System, number: u32) -> Finding {
    let what = "nothing can happen any more, though not everything has ended".into();
    Finding { what, span: None, run: lines(explored, system, number) }
}

impl System {
    /// A codel, or the service of a data transfer.
    #[must_use]
    pub fn node_name(&self, node: u16) -> String {
        let codels = &self.plan.component().codels;
        match codels.get(CodelIx::new(node.into())) {
            Some(codel) => codel.name.clone(),
            None => {
                let service = usize::from(node).saturating_sub(codels.len());
                format!("the transfer of {}", self.service_name(crate::codels::small(service)))
            }
        }
    }
}

/// A shortest run to a state, in words.
pub(super) fn lines(explored: &Explored, system: &System, number: u32) -> Vec<Line> {
    let run = explored.run_to(system, number);
    run.iter().filter_map(|(state, action)| system.words(state, *action)).collect()
}
