//! Ticks of components that are too large to see all their zones: from sums, and from what happens
//! if clients request few services.

use crate::explore::{Limit, Limits};
use crate::played::Course;
use crate::property::needed;
use crate::schedule::{Processors, Scheduled};
use crate::system::System;
use crate::timed::{TaskReport, TimedReport, Times, walk};

impl System {
    /// Whether tasks end their cycles before their next ticks. A component whose zones are too many
    /// for a first look is decided by sums where these are small enough, and by parts of it where one
    /// of these is late.
    #[must_use]
    pub fn check_ticks(&self, times: &Times, limits: &Limits) -> TimedReport {
        let first = self.check_times(times, &limits.first());
        if first.limit().is_none() {
            return first;
        }
        let sums = self.schedule(times, Processors::Own, 0);
        let mut report = first;
        report.by_sums(&sums.tasks);
        let periodic = self.periods.iter().zip(0u16..).filter(|(period, _)| period.is_some());
        for (at, (_, task)) in periodic.enumerate() {
            if report.tasks[at].is_open() {
                let parts = self.parts(&sums.tasks[at]);
                let run = parts.iter().find_map(|part| walk(part, times, task));
                if let Some(run) = run {
                    report.tasks[at].overrun = self.dated(times, &run);
                    report.tasks[at].course = Course { steps: run };
                    report.tasks[at].open = false;
                }
            }
        }
        if !report.tasks.iter().any(TaskReport::is_open) {
            report.explored.limit = None;
            return report;
        }
        // There is more to see.
        let mut whole = self.check_times(times, limits);
        for (task, known) in whole.tasks.iter_mut().zip(report.tasks) {
            if task.is_open() && !known.is_open() {
                *task = known;
            }
        }
        if !whole.tasks.iter().any(TaskReport::is_open) {
            whole.explored.limit = None;
        }
        whole
    }

    /// Parts of the component that may show that a task is late: with the services in its dearest
    /// cycle, then with those that it may wait for; each once, without aborts, and as the bounds say.
    fn parts(&self, task: &Scheduled) -> Vec<Self> {
        let called = || task.called.iter();
        let activities: Vec<&String> = called().filter_map(|one| one.activity.as_ref()).collect();
        let waits = called().flat_map(|one| one.waits.iter().map(|waits| &waits.of));
        let all: Vec<&String> = activities.iter().copied().chain(waits).collect();
        let mut parts = Vec::new();
        for names in [activities, all] {
            let services = 0..crate::codels::small(self.services.len());
            let meant = services.filter(|service| names.contains(&&self.service_name(*service)));
            let meant: Vec<u16> = meant.flat_map(|service| needed(self, service)).collect();
            for small in [true, false] {
                let mut part = self.slice(&meant);
                if small {
                    let bounds = &mut part.bounds;
                    (bounds.instances, bounds.abort, bounds.fire) = (1, false, false);
                }
                parts.push(part);
            }
        }
        parts
    }
}

impl TimedReport {
    /// Tasks that are in time by sums.
    fn by_sums(&mut self, sums: &[Scheduled]) {
        let limit: Option<Limit> = self.limit();
        for (task, sum) in self.tasks.iter_mut().zip(sums) {
            task.open = limit.is_some() && task.overrun.is_empty();
            if let (true, Ok(response)) = (task.open, &sum.response) {
                (task.open, task.response) = (false, Some(*response));
            }
        }
    }
}
