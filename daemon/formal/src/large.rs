//! Ticks of components that are too large to see all their zones: from sums, and from what happens
//! if clients request few services.

use std::time::Instant;

use crate::played::Course;
use crate::schedule::Processors;
use crate::system::System;
use crate::timed::{Timed, TimedReport, Times};
use genom_timing::{Limit, Limits};

/// The part of the time that all looks at ticks together have, in fifths: states and responses are
/// looked at, too.
const FIFTHS: u32 = 3;
/// How often late runs of all tasks are looked for, at most.
const ROUNDS: u64 = 2;

impl System {
    /// Whether tasks end their cycles before their next ticks. Tasks that have nothing to do with
    /// each other are looked at by themselves. What has too many zones for a first look is decided by
    /// sums where these are small enough, and by parts of it where one of these is late.
    #[must_use]
    pub fn check_ticks(&self, times: &Times, limits: &Limits) -> TimedReport {
        let mut all = TimedReport::default();
        let (begin, first, parts) = (Instant::now(), limits.first(), self.apart());
        let whole = Limits { time: limits.time / 5 * FIFTHS, ..*limits };
        let mut others = parts.len();
        for (tasks, part) in parts {
            others -= 1;
            let first = first.share(begin, others);
            let whole = whole.share(begin, others);
            let mut found = part.check_group(times, (&first, &whole), &tasks);
            if part.looked_at.contains(&false) {
                for (task, found) in tasks.iter().zip(&mut found.tasks) {
                    if found.is_late() {
                        found.course = self.course_of_all(times, limits, *task);
                    }
                }
            }
            all.add(found);
        }
        let limit = all.explored.limit;
        let is_own =
            matches!(limit, Some(Limit::Memory(_))) || limit == Some(Limit::States(limits.states));
        if !is_own && all.tasks.iter().any(|task| task.open) {
            // Not that of a first look.
            all.explored.limit = Some(Limit::Time(limits.time));
        }
        let order = |name: &str| self.plan.component().tasks.iter().position(|t| t.name == name);
        all.tasks.sort_by_key(|task| order(&task.name));
        all
    }

    /// A run of all tasks in which this one is late, as the runtime plays it; empty if a first look
    /// finds none.
    fn course_of_all(&self, times: &Times, limits: &Limits, task: u16) -> Course {
        let late = usize::from(task);
        let explored = Timed::until(self, times, &limits.first(), Some(late));
        let run = explored.overruns[late].map(|overrun| explored.run_to(self, overrun));
        Course { steps: run.unwrap_or_default() }
    }

    /// The same for the tasks that are looked at.
    fn check_group(
        &self,
        times: &Times,
        (first, limits): (&Limits, &Limits),
        tasks: &[u16],
    ) -> TimedReport {
        let begin = Instant::now();
        let mut report = self.check_times(times, first);
        if report.limit().is_none() {
            return report;
        }
        let sums = self.bounded(times, Processors::Own, 0);
        let sum = |name: &str| sums.tasks.iter().find(|sum| sum.name == name);
        for task in &mut report.tasks {
            if let (true, Some(Ok(most))) = (task.open, sum(&task.name).map(|sum| &sum.response)) {
                (task.open, task.response, task.bound) = (false, Some(*most), true);
                task.slowest.clear();
            }
        }
        let mut latest = Vec::new();
        if report.tasks.iter().any(|task| task.open) {
            latest = self.latest(times);
            for (task, found) in tasks.iter().zip(&mut report.tasks) {
                if let (true, Some(latest)) = (found.open, &latest[usize::from(*task)]) {
                    (found.open, found.response, found.bound) = (false, Some(latest.cycle), true);
                    found.slowest.clear();
                }
            }
        }
        // The time that tasks have left which are soon found to be late is for the others.
        for round in 0..ROUNDS {
            let mut open = report.tasks.iter().filter(|task| task.open).count();
            for (task, found) in tasks.iter().zip(&mut report.tasks) {
                let Some(sum) = sum(&found.name).filter(|_| found.open) else { continue };
                open -= 1;
                let limits = limits.share(begin, open);
                let run = self.late_run(times, (*task, sum), &latest, (&limits, round));
                if let Some(run) = run {
                    (found.overrun, found.spent) = self.overrun(times, &run, *task);
                    found.open = false;
                    found.course = Course { steps: run };
                    // The longest cycle of what was seen need not be the longest one.
                    found.response = None;
                    found.slowest.clear();
                }
            }
        }
        let left = limits.share(begin, 0);
        if left.time > first.time && report.tasks.iter().any(|task| task.open) {
            // There is more to see.
            let mut whole = self.check_times(times, &left);
            for (task, known) in whole.tasks.iter_mut().zip(report.tasks) {
                if task.open && !known.open {
                    *task = known;
                }
            }
            report = whole;
        }
        if !report.tasks.iter().any(|task| task.open) {
            report.explored.limit = None;
        }
        report
    }
}
