//! Applies the rules of a task, with exclusion, statistics and reports to control.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_description::model::{CodelIx, Ix as _, Owner, ServiceIx, StateIx, TaskIx};
use rtrb::Producer;

use super::core::{Calls, Core, Passed};
use super::gate::{Gate, Inside, TaskSide};
use super::run::{Mode, Run, RunOutcome, Token};
use crate::body::Returned;
use crate::rules::{Bound, Fact, Formulas, Happening, Heard, Seen};
use crate::shared::{Notice, Shared};

/// One task of an instance; driven by a thread, or by the thread that steps a virtual clock.
pub(crate) struct Runner {
    shared: Arc<Shared>,
    task: TaskIx,
    /// Its activities, which others look at between two passes.
    gate: Arc<Gate>,
    /// Buffer for the states of external events.
    fired: Vec<StateIx>,
    /// Whether the first codel of the permanent activity has run.
    started: bool,
    /// Date at which the last pass ended, in nanoseconds.
    end: u64,
}

impl Runner {
    pub(crate) fn new(shared: Arc<Shared>, task: TaskIx, side: TaskSide) -> Self {
        let model = shared.plan.component();
        let periodic = shared.tasks[task].timing.is_some();
        let by_period = shared.plan.steps_by_period() && periodic;
        let fired = Vec::with_capacity(model.sinks.len());
        // Capacity for all runs that the task can have at once: it never allocates.
        let core = Core::new(side.inbox.buffer().capacity() + 2, by_period);
        let gate =
            Arc::new(Gate::new(Inside { core, side, own: shared.rules.own(task), passed: 0 }));
        Self { shared, task, gate, fired, started: false, end: 0 }
    }

    pub(crate) fn gate(&self) -> &Arc<Gate> {
        &self.gate
    }

    pub(crate) fn task(&self) -> TaskIx {
        self.task
    }

    pub(crate) fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }

    /// Date at which the last pass ended.
    pub(crate) fn end(&self) -> u64 {
        self.end
    }

    /// One pass at date `now`. Wakes the other tasks if something moved; the caller continues this
    /// one.
    pub(crate) fn pass(&mut self, runnable: bool, now: u64) -> Passed {
        self.end = now;
        let (shared, task) = (&self.shared, self.task);
        let mut inside = self.gate.lock();
        while self.started && shared.held.load(Ordering::Acquire) {
            if !shared.takes_over.load(Ordering::Acquire) {
                return Passed::default();
            }
            // This tick is the first that is served here instead of in another instance.
            drop(inside);
            shared.turnstile.lock();
            shared.turnstile.unlock();
            inside = self.gate.lock();
        }
        if runnable {
            inside.passed = now;
            if self.started && shared.was_served(task, now) {
                return Passed::default();
            }
        }
        inside.admit_sent();
        let Inside { core, side, own, .. } = &mut *inside;
        shared.tasks[task].take_fired(&shared.plan, &mut self.fired);
        if core.is_empty() {
            return Passed::default();
        }
        let TaskSide { notices, broken, outbox, .. } = side;
        let mut calls = Caller { shared, task, now, notices, broken, own };
        let passed = core.pass(&shared.plan, runnable, &self.fired, &mut calls);
        self.end = calls.now;
        if passed.moved {
            let end = calls.now;
            hand_back((shared.as_ref(), task), end, core, (outbox, broken, own));
        }
        drop(inside);
        if passed.moved {
            shared.wake_others(task);
        }
        if !self.started && runnable {
            self.started = true;
            shared.tasks[task].first_codel_done();
        }
        passed
    }

    /// Records missed ticks, and reports them to watchers.
    pub(crate) fn overran(&mut self, ticks: u64) {
        self.shared.tasks[self.task].figures.overruns.missed(ticks);
        let notice = Notice::Overrun { task: self.task, ticks };
        self.shared.notify(&mut self.gate.lock().side.notices, notice);
        if self.shared.rules.watches_ticks(self.task) {
            self.shared.wake_control();
        }
    }
}

impl Runner {
    /// A cycle begins at this date.
    #[inline]
    pub(crate) fn cycle_begins(&mut self, now: u64) {
        let shared = &self.shared;
        shared.tasks[self.task].figures.cycles.begins(now);
        let heard = shared.rules.cycle(self.task).heard;
        if heard.is_heard() {
            let mut inside = self.gate.lock();
            let Inside { side, own, .. } = &mut *inside;
            let (what, broken) = ((Happening::Cycle(self.task), 0, now), &mut side.broken);
            shared.rules.hear(what, heard, own, |seen| shared.violated(broken, seen));
        }
    }

    /// The cycle ends at this date.
    #[inline]
    pub(crate) fn cycle_ends(&mut self, end: u64) {
        let (shared, cycles) = (&self.shared, &self.shared.tasks[self.task].figures.cycles);
        cycles.ends(end);
        let (began, longest) = (cycles.last(), shared.rules.cycle(self.task).longest);
        let ns = end.saturating_sub(began);
        if ns > longest {
            let mut inside = self.gate.lock();
            let broken = &mut inside.side.broken;
            shared.rules.cycled(self.task, (began, ns, true), |rule, fact| {
                shared.violated(broken, Seen { rule, activity: 0, date: end, fact });
            });
        }
    }
}

impl Drop for Runner {
    /// Releases memory and code of the component, as whoever waits for this thread expects.
    fn drop(&mut self) {
        let mut inside = self.gate.lock();
        inside.admit_sent();
        inside.core.clear();
    }
}

/// The service whose activity a run is.
fn service_of(shared: &Shared, run: &Run) -> Option<ServiceIx> {
    match shared.plan.machines()[run.machine].owner {
        Owner::Service(service) => Some(service),
        Owner::Task(_) => None,
    }
}

/// Gives control the runs that have ended, at this date.
fn hand_back(
    (shared, task): (&Shared, TaskIx),
    end: u64,
    core: &mut Core,
    (outbox, broken, own): (&mut Producer<Box<Run>>, &mut Option<Producer<Seen>>, &mut Formulas),
) {
    let mut any = false;
    core.take_ended(|mut run| {
        any = true;
        if run.outcome != Some(RunOutcome::Cancelled) {
            shared.rules.ends(run.machine);
            if let Some(service) = service_of(shared, &run) {
                let what = Happening::End(service);
                let tell = |seen| shared.violated(broken, seen);
                let heard = shared.rules.hears(what);
                shared.rules.hear((what, run.id, end), heard, own, tell);
            }
        }
        let machine = &shared.plan.machines()[run.machine];
        if let (Some(RunOutcome::Success), Some(node)) =
            (run.outcome, shared.fetch_node(machine.owner))
        {
            // dialects.md A: outputs are read from the IDS at the end.
            let _permit = shared.exclusion.enter(task.index(), node);
            run.frame.fetch();
        }
        // The ring has room for every possible run.
        let _ = outbox.push(run);
    });
    if any {
        shared.wake_control();
    }
}

/// Calls codels for the rules.
struct Caller<'a> {
    shared: &'a Shared,
    task: TaskIx,
    /// Date at which the last codel ended, and the next one starts, in nanoseconds.
    now: u64,
    notices: &'a mut Option<Producer<Notice>>,
    broken: &'a mut Option<Producer<Seen>>,
    own: &'a mut Formulas,
}

impl Caller<'_> {
    /// Sends control what an activity did.
    fn violated(&mut self, run: &Run, rule: usize, fact: Fact) {
        let seen = Seen { rule, activity: run.id, date: self.now, fact };
        self.shared.violated(self.broken, seen);
    }

    /// An activity does something that rules may hear of.
    #[inline]
    fn happens(&mut self, run: &Run, (what, by): (Happening, Heard), now: u64) {
        let Self { shared, broken, own, .. } = self;
        shared.rules.hear((what, run.id, now), by, own, |seen| {
            shared.violated(broken, seen);
        });
    }

    /// A codel has returned, which rules hear of, and may have written ports that they hear of.
    /// What it excluded is still excluded, so that all hear this before what comes after it. Returns
    /// the date.
    fn returned(&mut self, run: &Run, codel: CodelIx, bound: Bound) -> u64 {
        let now = self.shared.clock.now();
        if bound.writes {
            let Self { shared, broken, own, .. } = self;
            let tell = |seen| shared.violated(broken, seen);
            shared.rules.wrote(&*shared.body, codel, run.id, now, Some(&mut **own), tell);
        }
        self.happens(run, (Happening::Return(codel), bound.returns), now);
        now
    }
}

impl Calls for Caller<'_> {
    #[inline]
    fn call(&mut self, run: &mut Run, codel: CodelIx) -> Returned {
        let shared = self.shared;
        let permit = shared.exclusion.enter(self.task.index(), shared.plan.nodes().codel(codel));
        if permit.waited() {
            self.now = shared.clock.now();
        }
        shared.calls(codel, |rule, fact| self.violated(run, rule, fact));
        let bound = shared.rules.bound(codel);
        if bound.called.is_heard() {
            self.happens(run, (Happening::Call(codel), bound.called), self.now);
        }
        let context = self.task.index();
        let (at_work, since) = (&shared.at_work[context], shared.clock.real(self.now));
        at_work.begins(codel, run.id, since);
        let returned = run.frame.call(codel, context);
        at_work.ends();
        let heard = bound.returns.is_heard() || bound.writes;
        let heard = heard.then(|| self.returned(run, codel, bound));
        drop(permit);
        let end = heard.unwrap_or_else(|| shared.clock.now());
        let ns = end.saturating_sub(self.now);
        self.now = end;
        let call = (context, since);
        shared.called(codel, (returned, ns), call, |rule, fact| self.violated(run, rule, fact));
        returned
    }

    fn begins(&mut self, run: &Run) {
        self.shared.rules.begins(run.machine);
        if let Some(service) = service_of(self.shared, run) {
            let what = Happening::Start(service);
            self.happens(run, (what, self.shared.rules.hears(what)), self.now);
        }
    }

    #[inline]
    fn stepped(&mut self, run: &Run, from: StateIx, to: StateIx) {
        let rules = &self.shared.rules;
        if rules.looks_at_steps(run.machine) {
            let owner = self.shared.plan.machines()[run.machine].owner;
            rules.stepped(owner, (from, to), |rule, fact| self.violated(run, rule, fact));
        }
    }

    fn goes_on(&mut self, codel: CodelIx) {
        self.shared.tasks[self.task].figures.cycles.goes_on(codel);
    }

    fn moved(&mut self, run: &Run, token: Token) {
        if self.notices.is_some() {
            let (state, paused) = (token.state, token.mode != Mode::Ready);
            let notice = Notice::Moved { activity: run.id, state, paused };
            self.shared.notify(self.notices, notice);
        }
    }
}
