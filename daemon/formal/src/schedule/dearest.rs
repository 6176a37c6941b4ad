//! The dearest ways of a task's activities, state by state, with what they may wait for.

use super::contexts::{Adds, Contexts};
use super::cycle::Costs;
use super::ways::Ways;
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;

/// What the states of a machine cost.
struct Machine {
    begun: u64,
    stop: Option<u64>,
    /// For each state, the dearest way from it on, the dearest that does not end the activity if
    /// there is one, and what its own codel costs of these.
    from: Vec<(u64, Option<u64>, u64)>,
}

/// What may follow in one cycle of a task.
pub(crate) struct Dearest {
    machines: Vec<Option<Machine>>,
}

impl Dearest {
    /// If other contexts execute what `may` says; `None` if a cycle may have no end.
    pub(crate) fn new(
        system: &System,
        times: &Times,
        task: u16,
        may: &dyn Fn(u16, u16) -> bool,
    ) -> Option<Self> {
        let contexts =
            Contexts::with(system, &|context, node| context == task || may(context, node));
        let all = |_: u16| true;
        let costs = Costs::new(system, times, &contexts, task, (&all, Adds::Chain)).costs;
        let machine = |machine: &crate::machines::Machine| {
            if machine.task != task {
                return Some(None);
            }
            let ways = Ways { system, machine, costs: &costs };
            let cost = |state: u16| ways.from(state, false).ok().map(|way| way.cost);
            let later = |state: u16| {
                let way = ways.from(state, true).ok()?;
                Some(Some(way.cost).filter(|_| !way.codels.is_empty()))
            };
            let own = |state: u16| machine.codel(state).map_or(0, |c| costs[usize::from(c)]);
            let states = 0..small(machine.codels.len());
            let from = states.map(|state| Some((cost(state)?, later(state)?, own(state))));
            let stop = machine.codel(machine.stop).and_then(|_| cost(machine.stop));
            let all = later(machine.start)?.zip(stop).map(|(way, stop)| way.saturating_add(stop));
            Some(Some(Machine {
                begun: cost(machine.start)?.max(all.unwrap_or(0)),
                stop,
                from: from.collect::<Option<_>>()?,
            }))
        };
        Some(Self { machines: system.machines.iter().map(machine).collect::<Option<_>>()? })
    }

    fn machine(&self, machine: u16) -> Option<&Machine> {
        self.machines.get(usize::from(machine))?.as_ref()
    }

    /// An activity that begins.
    pub(crate) fn begun(&self, machine: u16) -> u64 {
        self.machine(machine).map_or(0, |machine| machine.begun)
    }

    /// From `stop` on, if there is such a codel.
    pub(crate) fn stop(&self, machine: u16) -> Option<u64> {
        self.machine(machine)?.stop
    }

    /// From a state on, with `later` without end of the activity, if it need not end; with `after`
    /// without the codel of that state itself.
    pub(crate) fn from(&self, machine: u16, state: u16, later: bool, after: bool) -> Option<u64> {
        let (ends, goes_on, own) = *self.machine(machine)?.from.get(usize::from(state))?;
        let all = if later { goes_on? } else { ends };
        Some(if after { all.saturating_sub(own) } else { all })
    }
}
