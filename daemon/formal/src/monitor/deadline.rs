//! Deadlines of codels and cycles, and missed ticks.

use std::time::{Duration, Instant};

use genom_description::model::{CodelIx, CodelKind, Ix as _, Owner, TaskIx};
use genom_runtime::{Happening, Part, Program, STUCK_AFTER, nanos, patience};
use genom_timing::{Limits, duration};

use super::cycles::Cycles;
use super::fires::{Fires, Trace, undecided};
use super::search::Watched;
use super::ticks::Ticks;
use crate::system::System;
use crate::timed::{TaskReport, Times};

impl System {
    /// Calls of codels that take longer than their limits.
    pub(super) fn longest(
        &self,
        codels: &[(CodelIx, Duration)],
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        // Times of other codels do not matter here.
        let declared = self.declared_times();
        let times = times.unwrap_or(&declared);
        let of = |ix: &CodelIx| times.of(crate::codels::small(ix.index()));
        let over = |(ix, limit): &&(CodelIx, Duration)| {
            of(ix).most.is_none_or(|most| most > nanos(*limit))
        };
        let slow: Vec<&(CodelIx, Duration)> = codels.iter().filter(over).collect();
        if slow.is_empty() {
            return Fires::Never;
        }
        let calls = slow.iter().map(|(ix, _)| Happening::Call(*ix)).collect();
        let parts = [(Part::Happens(calls), String::new()), (Part::Not(0), String::new())];
        let Ok(program) = Program::new(parts.into()) else { return undecided("it has no codels") };
        let run = match self.search(&Watched::Formula(&program), limits) {
            // All that is heard breaks this formula.
            Fires::Can { run, .. } | Fires::Always { run, .. } => run,
            // They are never called.
            other => return other,
        };
        let name = |ix: CodelIx| self.plan.component().codels[ix].name.clone();
        if let Some((ix, _)) = slow.iter().find(|(ix, _)| of(ix).most.is_none()) {
            return Fires::Undecided(format!("codel {} has no wcet: give --wcet", name(*ix)));
        }
        let Some((ix, limit)) = slow.first() else { return Fires::Never };
        let what = format!(
            "codel {} may take {}, and {} are allowed",
            name(*ix),
            duration(of(ix).most.unwrap_or_default()),
            duration(nanos(*limit))
        );
        match codels.iter().all(|(ix, limit)| of(ix).least > nanos(*limit)) {
            true => Fires::Always { what, run },
            false => Fires::Can { what, run },
        }
    }

    /// Calls of codels that count as stuck, with the default of `stuck_after`.
    pub(super) fn stuck(
        &self,
        codels: &[CodelIx],
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let model = self.plan.component();
        let limit = |ix: &CodelIx| {
            let codel = &model.codels[*ix];
            // Who calls it: a task, or the worker of a request.
            let task = match codel.owner {
                _ if !matches!(codel.kind, CodelKind::Fsm { .. }) => None,
                Owner::Task(task) => Some(task),
                Owner::Service(service) => model.services[service].task,
            };
            let period = task.and_then(|task| self.periods.get(task.index()).copied().flatten());
            let most = patience(period.map(|period| period.period), nanos(STUCK_AFTER));
            (*ix, Duration::from_nanos(most.max(codel.wcet.map_or(0, nanos))))
        };
        self.longest(&codels.iter().map(limit).collect::<Vec<_>>(), times, limits)
    }

    /// Cycles that take longer.
    pub(super) fn cycle(
        &self,
        task: TaskIx,
        longest: Duration,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let (times, _) = match self.periodic(task, times) {
            Ok(found) => found,
            Err(why) => return undecided(why),
        };
        let (begin, limit) = (Instant::now(), nanos(longest));
        let mut cycles = Cycles { task: crate::codels::small(task.index()), limit };
        let seen = self.clocked(&mut cycles, Ok(times), &limits.share(begin, 1));
        let Fires::Undecided(why) = seen else { return seen };
        // What is too large may be decided by its parts, from ticks on.
        let limits = limits.share(begin, 0);
        self.with_report(task, times, &limits, |report, all_seen| match report.response {
            // A tick that was kept is before the beginning of its cycle.
            Some(most) if most > limit && !report.is_late() && !report.slowest.is_empty() => {
                let what = format!(
                    "a cycle of task {} may take {}, and {} are allowed",
                    report.name,
                    duration(most),
                    duration(limit)
                );
                // The dates are not those of a cycle that takes so long.
                let run = report.slowest.iter().map(|dated| dated.line.clone()).collect();
                Fires::Can { what, run: Trace::Steps(run) }
            }
            Some(most) if most <= limit && all_seen => Fires::Never,
            _ => Fires::Undecided(why),
        })
    }

    /// Missed ticks.
    pub(super) fn missed(
        &self,
        task: TaskIx,
        (ticks, within): (u64, Duration),
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let (times, period) = match self.periodic(task, times) {
            Ok(found) => found,
            Err(why) => return undecided(why),
        };
        let (begin, number) = (Instant::now(), crate::codels::small(task.index()));
        let mut watch = Ticks::new(number, ticks, (period, nanos(within)));
        let seen = self.clocked(&mut watch, Ok(times), &limits.share(begin, 2));
        match seen {
            Fires::Never if watch.perhaps => undecided(
                "so many can be missed, and whether that is within the window depends on when the \
                 runtime looks",
            ),
            Fires::Undecided(why) => {
                watch.startup = true;
                let first = self.clocked(&mut watch, Ok(times), &limits.share(begin, 1));
                let limits = limits.share(begin, 0);
                self.with_report(task, times, &limits, |report, all_seen| {
                    let never = !report.is_late() && all_seen && first == Fires::Never;
                    match (report.is_late(), ticks) {
                        (true, 1) => {
                            let what = format!("{} is still at work at its tick", report.name);
                            Fires::Can { what, run: Trace::Dated(report.overrun.clone()) }
                        }
                        _ if never => Fires::Never,
                        _ => Fires::Undecided(why),
                    }
                })
            }
            other => other,
        }
    }

    /// The times, and the period of a task; or why nothing is known of its cycles.
    fn periodic<'t>(
        &self,
        task: TaskIx,
        times: Result<&'t Times, &'t str>,
    ) -> Result<(&'t Times, u64), &'t str> {
        let period = self.periods.get(task.index()).copied().flatten();
        let period = period.ok_or("the task has no period: when it is woken is not known")?;
        let number = crate::codels::small(task.index());
        if !self.is_looked_at(number) {
            return Err(
                "the task does nothing once requests are served: its ticks are not explored",
            );
        }
        Ok((times?, period.period))
    }

    fn with_report(
        &self,
        task: TaskIx,
        times: &Times,
        limits: &Limits,
        judge: impl FnOnce(&TaskReport, bool) -> Fires,
    ) -> Fires {
        let name = self.task_name(crate::codels::small(task.index()));
        let found = self.check_ticks(times, limits);
        match found.tasks.iter().find(|one| one.name == name) {
            Some(report) => judge(report, found.limit().is_none() && !report.is_open()),
            None => undecided("not all was seen"),
        }
    }
}
