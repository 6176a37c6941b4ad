//! Runs that break a rule on time, with the earliest dates at which they do.

use genom_timing::{Age, Trail, Zone, along};

use super::fires::Trace;
use crate::action::Action;
use crate::state::State;
use crate::system::System;
use crate::timed::{Dated, Table, Times, dates_of};
use crate::words::Line;

/// States with values of their clocks, and what becomes of the dates of a rule on the way to each.
#[derive(Default)]
pub(super) struct Traced {
    pub(super) table: Table,
    trails: Vec<Trail>,
    trail_bytes: usize,
}

/// Where a rule is broken first: the node, and the step from it, or time that passes there.
pub(super) struct Broken {
    node: u32,
    action: Option<Action>,
    /// What breaks it, and how long ago the dates of the rule are then: one way or several.
    ways: Vec<(String, Trail)>,
}

impl Broken {
    /// One more way, if it is the first place or the same one.
    pub(super) fn note(
        all: &mut Option<Self>,
        (node, action): (u32, Option<Action>),
        (what, ages): (String, Vec<(usize, Age)>),
    ) {
        let broken = all.get_or_insert(Self { node, action, ways: Vec::new() });
        if (broken.node, broken.action) == (node, action) {
            broken.ways.push((what, Trail { dates: Vec::new(), ages }));
        }
    }
}

impl Traced {
    /// Adds a node, unless another one has all its values, with what the step to it makes of dates.
    pub(super) fn add(
        &mut self,
        (state, along): (&State, u32),
        zone: Zone,
        before: (u32, u16),
        trail: Trail,
    ) {
        if self.table.add_with(state, Some(along), zone, before).is_some() {
            self.trail_bytes += trail.bytes();
            self.trails.push(trail);
        }
    }

    /// Memory that all takes, about.
    pub(super) fn bytes(&self) -> usize {
        self.table.bytes() + self.trail_bytes
    }

    /// What breaks the rule at the earliest, and the run to it.
    pub(super) fn run(&self, system: &System, times: &Times, broken: Broken) -> (String, Trace) {
        let Broken { node, action, ways } = broken;
        let state = self.table.state(node);
        let mut run = self.table.way_to(system, node);
        run.extend(state.clone().zip(action));
        let waits = state.as_ref().filter(|_| action.is_none());
        let nodes = self.table.nodes_to(node);
        let dates = |end: &Trail| {
            let trails = nodes.iter().filter_map(|node| self.trails.get(*node as usize));
            dates_of(system, times, &run, waits, along(trails.chain([end])))
        };
        let ways = ways.into_iter().map(|(what, end)| (what, dates(&end)));
        let first = ways.min_by_key(|(_, dates)| dates.last().copied());
        let (what, dates) = first.unwrap_or_default();
        let mut lines = system.dated(&run, &dates);
        let date = dates.last().copied().unwrap_or_default();
        // The last line has the date at which it is broken.
        let last = action.and(run.last_chunk::<1>());
        if last.is_none_or(|last| system.dated(last, &[date]).is_empty()) {
            let line = Line { who: "rule".into(), what: "is broken".into(), span: None };
            lines.push(Dated { date, line });
        }
        (what, Trace::Dated(lines))
    }
}
