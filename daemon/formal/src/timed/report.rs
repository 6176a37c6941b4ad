//! Whether tasks end their cycles in time, and a run that shows where one does not.

use super::dates::dates;
use super::explore::Timed;
use super::respond::Response;
use super::slack::involved;
use super::spent::Spent;
use super::times::Times;
use crate::action::Action;
use crate::played::Course;
use crate::state::State;
use crate::system::System;
use crate::words::Line;
use genom_timing::{Limit, Limits};

/// What was found about the time of a component.
#[derive(Debug, Default)]
pub struct TimedReport {
    /// Periodic tasks in the model's order.
    pub tasks: Vec<TaskReport>,
    /// How long clients of activities wait, if that was asked for.
    pub responses: Vec<Response>,
    /// What was explored.
    pub explored: Seen,
}

/// How much was explored.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    states: usize,
    zones: usize,
    /// What ended the exploration before all was seen.
    pub limit: Option<Limit>,
}

impl Seen {
    /// Number of states, without values of clocks.
    #[must_use]
    pub fn states(&self) -> usize {
        self.states
    }

    /// Number of zones: those that no other one includes.
    #[must_use]
    pub fn zones(&self) -> usize {
        self.zones
    }
}

/// A task that has a period.
#[derive(Debug)]
pub struct TaskReport {
    /// Its name.
    pub name: String,
    /// Its period, in nanoseconds.
    pub period: u64,
    /// The longest time from a tick to the end of the cycle that it begins, in nanoseconds; `None`
    /// if there is no bound, or no cycle.
    pub response: Option<u64>,
    /// A run to the end of a cycle that may take that long; empty if none was seen. Dates are the
    /// earliest ones.
    pub slowest: Vec<Dated>,
    /// The response is a bound by sums, above which none is; it may be that none is that long.
    pub bound: bool,
    /// A run in which a tick comes while the task is at work; empty if there is none.
    pub overrun: Vec<Dated>,
    /// What it does in that run from its last tick but one on; together, that is its period, unless it
    /// is late in its first cycle.
    pub spent: Vec<Spent>,
    /// A run of all tasks to an overrun, step by step; empty if there is none, or none was found.
    pub course: Course,
    /// Codels, and the time in nanoseconds below which each would have to stay so that there is no
    /// such run, the others as they are.
    pub needed: Vec<(String, u64)>,
    /// Not decided: not all was seen, and no run shows that it is late.
    pub(crate) open: bool,
}

/// What happens at a date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dated {
    /// Nanoseconds from the start of the component.
    pub date: u64,
    /// What happens.
    pub line: Line,
}

impl System {
    /// Explores what the component can do if its codels take these times.
    #[must_use]
    pub fn check_times(&self, times: &Times, limits: &Limits) -> TimedReport {
        let explored = Timed::new(self, times, limits);
        let periodic = self.periods.iter().enumerate();
        let periodic = periodic.filter(|(at, _)| self.looked_at[*at]);
        let task = |(at, period): (usize, &Option<crate::Period>)| {
            let run = explored.overruns[at].map(|overrun| explored.run_to(self, overrun));
            let run = run.unwrap_or_default();
            let codels = involved(&run, crate::codels::small(at));
            let needed = if run.is_empty() {
                Vec::new()
            } else {
                self.needed(times, limits, at, (&codels, explored.zones()))
            };
            let (overrun, spent) = self.overrun(times, &run, crate::codels::small(at));
            let named = |(codel, most): (u16, u64)| (self.node_name(codel), most);
            Some(TaskReport {
                name: self.task_name(crate::codels::small(at)),
                period: (*period)?.period,
                response: explored.responses[at].flatten(),
                bound: false,
                open: run.is_empty() && explored.limit.is_some(),
                slowest: explored.slowest[at]
                    .map(|end| explored.run_to(self, end))
                    .map(|run| self.dated(&run, &dates(self, times, &run)))
                    .unwrap_or_default(),
                overrun,
                spent,
                course: Course { steps: run },
                needed: needed.into_iter().map(named).collect(),
            })
        };
        let tasks = periodic.filter_map(task).collect();
        let (states, zones) = (explored.states(), explored.zones());
        let explored = Seen { states, zones, limit: explored.limit };
        TimedReport { tasks, responses: Vec::new(), explored }
    }

    /// What happens on the way to an overrun, with dates, and what the task does that is late.
    pub(crate) fn overrun(
        &self,
        times: &Times,
        run: &[(State, Action)],
        task: u16,
    ) -> (Vec<Dated>, Vec<Spent>) {
        let dates = dates(self, times, run);
        (self.dated(run, &dates), self.spent(run, &dates, task))
    }

    /// What happens in a run, of which each step has a date.
    pub(crate) fn dated(&self, run: &[(State, Action)], dates: &[u64]) -> Vec<Dated> {
        let mut told = Vec::new();
        let mut lines = Vec::new();
        for ((state, action), date) in run.iter().zip(dates.iter().copied()) {
            let next = self.after(state, *action, &mut told);
            let words = self.words(state, *action).into_iter();
            let words = words.chain(self.begun(state, *action, &next));
            lines.extend(words.map(|line| Dated { date, line }));
        }
        lines
    }

    /// What contexts begin to execute, or to wait for, by a step.
    fn begun(&self, state: &State, action: Action, next: &State) -> Vec<Line> {
        let returned = match action {
            Action::Return(context, _) => Some(context),
            _ => None,
        };
        let mut lines = Vec::new();
        for (context, node) in next.lock.holders() {
            if state.lock.held_by(context).is_none() || returned == Some(context) {
                let what = format!("{} begins", self.node_name(node));
                lines.push(self.line_of(next, context, node, what));
            }
        }
        for &(context, node) in &next.lock.queue {
            if state.lock.awaited_by(context).is_none() {
                let others = self.ahead(next, context).join(", ");
                let what = format!("{} waits for {others}", self.node_name(node));
                lines.push(self.line_of(next, context, node, what));
            }
        }
        lines
    }
}

impl TaskReport {
    /// Not decided.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// A run shows that it is late.
    #[must_use]
    pub fn is_late(&self) -> bool {
        !self.overrun.is_empty()
    }
}

impl TimedReport {
    /// Adds what was found of other tasks.
    pub(crate) fn add(&mut self, other: Self) {
        self.tasks.extend(other.tasks);
        self.explored.states += other.explored.states;
        self.explored.zones += other.explored.zones;
        self.explored.limit = self.explored.limit.or(other.explored.limit);
    }

    /// What ended the exploration before all was seen.
    #[must_use]
    pub fn limit(&self) -> Option<Limit> {
        self.explored.limit
    }
}
