//! What others see of an instance without the help of its tasks: activities over their time, missed
//! ticks, and codels that have not returned.

use std::sync::atomic::Ordering;
use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _, TaskIx};

use super::broken::{Fact, Seen};
use super::{Happening, Rule, Supervised};
use crate::clock::{Clock, monotonic, nanos};
use crate::control::{Afterwards, Control, Entry, Phase, Stage};
use crate::engine::Engine;
use crate::watcher::Change;

/// Name by which activities are asked to stop.
const BY: &str = "supervision";
/// Interval between looks, however short the limits: a codel that returned is seen by its own
/// thread, at once.
const OFTEN: u64 = 5_000_000;
const SELDOM: u64 = 250_000_000;

impl Engine {
    /// Tells a violation, and asks the activities to stop that the rule interrupts.
    pub(crate) fn violated(&self, control: &mut Control, seen: Seen, after: &mut Afterwards) {
        let rules = &self.shared.rules;
        let interrupts = rules.all.get(seen.rule).is_some_and(|one| one.interrupts);
        if interrupts {
            let concerned = |entry: &Entry| match seen.fact {
                Fact::Missed { task, .. } | Fact::Cycle { task, .. } => entry.task == task,
                Fact::Late { .. } if seen.activity == 0 => entry.service == rules.during(seen.rule),
                _ => entry.id == seen.activity,
            };
            for at in 0..control.entries.len() {
                let entry = &control.entries[at];
                if entry.service.is_some() && concerned(entry) {
                    self.stop(control, at, BY, after);
                }
            }
            // genom3.md 7.5: a paused activity wakes up, as after `abort_activity`.
            self.shared.wake_tasks();
        }
        let count = rules.count(seen.rule);
        let Some(Supervised { rule, .. }) = rules.all.get(seen.rule) else { return };
        let told = seen.violation(self.shared.plan.component(), rule, count);
        after.changes.push(Change::Violated(told));
    }

    /// Keeps what a codel of a request broke until control tells it.
    pub(crate) fn violated_aside(&self, rule: usize, fact: Fact) {
        self.seen_aside(Seen { rule, activity: 0, date: self.shared.clock.now(), fact });
    }

    /// Keeps what was broken outside tasks until control tells it.
    pub(crate) fn seen_aside(&self, seen: Seen) {
        let rules = &self.shared.rules;
        rules.set_aside(rules.counted(seen));
        self.shared.wake_control();
    }

    /// Something happens outside tasks, now.
    pub(crate) fn happens(&self, what: Happening, activity: u32) {
        let rules = &self.shared.rules;
        if rules.hears(what).others {
            let now = self.shared.clock.now();
            rules.hear_elsewhere((what, activity, now), |seen| self.seen_aside(seen));
        }
    }

    /// Something happened before the instance went on from another one, which told what it broke.
    pub(crate) fn happened(&self, what: Happening) {
        let now = self.shared.clock.now();
        self.shared.rules.hear_elsewhere((what, 0, now), |_| {});
    }

    /// Activities over their time, and ticks missed, at this date.
    pub(crate) fn look_at_rules(&self, control: &mut Control, now: u64, after: &mut Afterwards) {
        let rules = &self.shared.rules;
        if rules.is_empty() {
            return;
        }
        for at in 0..control.entries.len() {
            self.look_at_activity(control, at, now, after);
        }
        self.look_at_ticks(control, now, after);
        self.look_at_beats(control, now, after);
        for seen in rules.take_left() {
            self.violated(control, rules.counted(seen), after);
        }
    }

    /// Heartbeats that do not come in time.
    fn look_at_beats(&self, control: &mut Control, now: u64, after: &mut Afterwards) {
        let rules = &self.shared.rules;
        if self.awaits_beats(control) {
            for (rule, fact) in rules.late(now) {
                let seen = rules.counted(Seen { rule, activity: 0, date: now, fact });
                self.violated(control, seen, after);
            }
        }
    }

    /// Whether heartbeats are waited for: not before the start-up is over, nor once it is to stop,
    /// nor while its tasks are held.
    fn awaits_beats(&self, control: &Control) -> bool {
        control.phase == Phase::Running && !self.shared.held.load(Ordering::Acquire)
    }

    /// Tells the rules that an activity breaks by not having ended at this date.
    pub(crate) fn look_at_activity(
        &self,
        control: &mut Control,
        at: usize,
        now: u64,
        after: &mut Afterwards,
    ) {
        let rules = &self.shared.rules;
        let entry = &mut control.entries[at];
        let answered = matches!(entry.stage, Stage::Cancelled | Stage::Gone);
        let Some(service) = entry.service.filter(|_| !answered) else { return };
        let (activity, accepted, asked) = (entry.id, entry.accepted, entry.asked);
        let mut late = entry.late;
        for (rank, since, limit) in rules.of_activity(service, accepted, asked) {
            let ns = now.saturating_sub(since);
            // One that ends at this very date, which may come after this look, is in time.
            if ns > limit && late & 1 << rank == 0 {
                late |= 1 << rank;
                let fact = match rules.all[rank].rule {
                    Rule::Stop { .. } => Fact::Stop { service, ns },
                    _ => Fact::Activity { service, ns },
                };
                let seen = rules.counted(Seen { rule: rank, activity, date: now, fact });
                self.violated(control, seen, after);
            }
        }
        control.entries[at].late = late;
    }

    /// When the next activity will be over its time, or the next heartbeat will be too late.
    pub(crate) fn next_late(&self, control: &Control) -> Option<u64> {
        let rules = &self.shared.rules;
        if rules.is_empty() {
            return None;
        }
        let of = |entry: &Entry| {
            let answered = matches!(entry.stage, Stage::Cancelled | Stage::Gone);
            let service = entry.service.filter(|_| !answered)?;
            let limits = rules.of_activity(service, entry.accepted, entry.asked);
            let left = limits.filter(|(rank, ..)| entry.late & 1 << rank == 0);
            left.map(|(_, since, limit)| since.saturating_add(limit).saturating_add(1)).min()
        };
        let beat = rules.next_beat().filter(|_| self.awaits_beats(control));
        control.entries.iter().filter_map(of).chain(beat).min()
    }

    fn look_at_ticks(&self, control: &mut Control, now: u64, after: &mut Afterwards) {
        let rules = &self.shared.rules;
        let mut broken = Vec::new();
        for window in rules.windows().iter_mut() {
            let task = &self.shared.tasks[window.task];
            if let Some(ticks) = window.look(task.figures.overruns.read(task.timing, now), now) {
                broken.push((window.rule, Fact::Missed { task: window.task, ticks }));
            }
        }
        for (rule, fact) in broken {
            let seen = rules.counted(Seen { rule, activity: 0, date: now, fact });
            self.violated(control, seen, after);
        }
    }

    /// Looks for codels that have not returned in time, and for ticks that their tasks miss.
    /// Returns when to look again; `None` if no rule needs that.
    pub(crate) fn supervise(&self) -> Option<Duration> {
        let rules = &self.shared.rules;
        if rules.is_empty() {
            return None;
        }
        let stepped = !matches!(self.shared.clock, Clock::Monotonic);
        let (mut seen, mut next) = (Vec::new(), None);
        for (rank, Supervised { rule, .. }) in rules.all.iter().enumerate() {
            let due = match rule {
                Rule::Longest { codels } => {
                    let limits = codels.iter().map(|(codel, limit)| (*codel, nanos(*limit)));
                    self.look_at_calls(rank, &limits.collect::<Vec<_>>(), stepped, &mut seen)
                }
                Rule::Stuck { codels } => {
                    let limits: Vec<_> = codels.iter().map(|codel| (*codel, 0)).collect();
                    self.look_at_calls(rank, &limits, true, &mut seen)
                }
                Rule::Missed { task, .. } if !stepped => self.next_missed(rank, *task),
                Rule::Cycle { task, longest } if !stepped => {
                    self.look_at_cycle(rank, *task, nanos(*longest), &mut seen)
                }
                Rule::Beat { .. } if !stepped => rules
                    .next_beat()
                    .map_or(SELDOM, |due| due.saturating_sub(self.shared.clock.now())),
                _ => continue,
            };
            next = Some(next.map_or(due, |next: u64| next.min(due)));
        }
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            for seen in seen {
                self.violated(&mut control, rules.counted(seen), &mut after);
            }
            if !stepped {
                let now = self.shared.clock.now();
                self.look_at_ticks(&mut control, now, &mut after);
                self.look_at_beats(&mut control, now, &mut after);
            }
        }
        self.finish_off(after);
        next.map(|next| Duration::from_nanos(next.clamp(OFTEN, SELDOM)))
    }

    /// Calls of codels that have lasted longer than their limits, or with `stuck`, than that and
    /// what counts as stuck. Returns the time until one can be too long, in nanoseconds.
    fn look_at_calls(
        &self,
        rule: usize,
        limits: &[(CodelIx, u64)],
        stuck: bool,
        seen: &mut Vec<Seen>,
    ) -> u64 {
        let (rules, now) = (&self.shared.rules, monotonic());
        let mut next = if stuck {
            SELDOM
        } else {
            limits.iter().map(|(_, limit)| *limit).min().unwrap_or(SELDOM)
        };
        for context in 0..self.shared.outside_context() {
            let Some((codel, activity, since)) = self.shared.at_work[context].look() else {
                continue;
            };
            let Some((_, limit)) = limits.iter().find(|(own, _)| *own == codel) else { continue };
            let least = if stuck { self.stuck_limit(codel, context) } else { 0 };
            let (limit, ns) = ((*limit).max(least), now.saturating_sub(since));
            if ns <= limit {
                next = next.min(limit - ns + 1);
            } else if rules.claim(context, rule, since) {
                let task = self.shared.tasks.get(TaskIx::new(context));
                let thread = task.and_then(|task| task.thread_number()).unwrap_or_default();
                let (date, fact) = (self.shared.clock.now(), Fact::Lasts { codel, ns, thread });
                seen.push(Seen { rule, activity, date, fact });
            }
        }
        next
    }

    /// A cycle that has lasted longer than its limit. Returns the time until it can, in nanoseconds.
    fn look_at_cycle(&self, rule: usize, task: TaskIx, limit: u64, seen: &mut Vec<Seen>) -> u64 {
        let (rules, now) = (&self.shared.rules, self.shared.clock.now());
        let Some(lasting) = self.shared.tasks[task].figures.cycles.lasting(now) else {
            return limit;
        };
        let ns = lasting.for_ns;
        if ns <= limit {
            return limit - ns + 1;
        }
        if !rules.starts_up(lasting.began) && rules.claim(task.index(), rule, lasting.began) {
            let fact = Fact::Cycle { task, ns, over: false };
            seen.push(Seen { rule, activity: 0, date: now, fact });
        }
        limit
    }

    /// Time until so many ticks can have been missed as the rule allows, in nanoseconds.
    fn next_missed(&self, rule: usize, task: TaskIx) -> u64 {
        let left = {
            let windows = self.shared.rules.windows();
            windows.iter().find(|window| window.rule == rule).map_or(1, |window| window.left())
        };
        let period = self.shared.tasks[task].timing.map_or(SELDOM, |timing| timing.period);
        period.saturating_mul(left)
    }
}
