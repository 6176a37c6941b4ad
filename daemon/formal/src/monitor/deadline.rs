//! Deadlines of codels and cycles, and missed ticks.

use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _, TaskIx};
use genom_runtime::{Happening, Part, Program, nanos};

use super::fires::{Fires, undecided};
use super::search::Watched;
use crate::explore::Limits;
use crate::system::System;
use crate::text::duration;
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

    /// Cycles that take longer. A cycle begins at its tick.
    pub(super) fn cycle(
        &self,
        task: TaskIx,
        longest: Duration,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        self.with_report(task, times, limits, |report, all_seen| {
            let limit = nanos(longest);
            match report.response {
                Some(most) if most > limit && report.slowest.is_empty() => {
                    undecided("not all was seen, and sums alone do not decide it")
                }
                Some(most) if most > limit => {
                    let what = format!(
                        "a cycle of task {} may take {}, and {} are allowed",
                        report.name,
                        duration(most),
                        duration(limit)
                    );
                    let run = report.slowest.iter().map(|dated| dated.line.clone()).collect();
                    Fires::Can { what, run }
                }
                Some(_) if all_seen => Fires::Never,
                _ => undecided("not all was seen"),
            }
        })
    }

    /// Missed ticks.
    pub(super) fn missed(
        &self,
        task: TaskIx,
        ticks: u64,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        self.with_report(task, times, limits, |report, all_seen| match (report.is_late(), ticks) {
            (false, _) if all_seen => Fires::Never,
            (false, _) => undecided("not all was seen"),
            (true, 1) => {
                let what = format!("{} is still at work at its tick", report.name);
                let run = report.overrun.iter().map(|dated| dated.line.clone()).collect();
                Fires::Can { what, run }
            }
            (true, _) => undecided("one tick can be missed; how many, is not explored"),
        })
    }

    fn with_report(
        &self,
        task: TaskIx,
        times: Result<&Times, &str>,
        limits: &Limits,
        judge: impl FnOnce(&TaskReport, bool) -> Fires,
    ) -> Fires {
        let times = match times {
            Ok(times) => times,
            Err(why) => return undecided(why),
        };
        if self.periods.get(task.index()).copied().flatten().is_none() {
            return undecided("the task has no period: when it is woken is not known");
        }
        let name = self.task_name(crate::codels::small(task.index()));
        let found = self.check_ticks(times, limits);
        match found.tasks.iter().find(|one| one.name == name) {
            Some(report) => judge(report, found.limit().is_none() && !report.is_open()),
            None => undecided("not all was seen"),
        }
    }
}
