//! Rules as tables by index, so that the thread that runs codels looks nothing up.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use genom_description::model::{
    CodelIx, CodelKind, Indexed, Ix as _, Owner, ServiceIx, StateIx, TaskIx,
};

use super::alive::Window;
use super::broken::{Fact, Seen};
use super::formulas::Formulas;
use super::hear::{Heard, Hearing};
use super::{Rule, Supervised};
use crate::body::Body;
use crate::clock::nanos;
use crate::lock::{Guard, lock};
use crate::plan::Plan;
use genom_monitor::{Happening, Places};

/// Most violations by requests that wait for control.
const MOST_ASIDE: usize = 64;

/// What a call of one codel is compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// A call that takes longer, in nanoseconds, breaks a rule or its `wcet`.
    pub(crate) longest: u64,
    /// Its `wcet` in nanoseconds; `u64::MAX` without one.
    pub(crate) wcet: u64,
    /// Whether it may be called is looked at before each call.
    pub(crate) ordered: bool,
    /// Who hears of its calls, and of its returns.
    pub(crate) called: Heard,
    pub(crate) returns: Heard,
    /// Somebody hears of a port that it may write.
    pub(crate) writes: bool,
}

/// What the cycles of one task are compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CycleBound {
    /// A cycle that takes longer, in nanoseconds, breaks a rule.
    pub(crate) longest: u64,
    /// Who hears of their beginnings.
    pub(crate) heard: Heard,
}

/// The rules of one instance.
#[derive(Debug)]
pub(crate) struct Rules {
    pub(super) all: Vec<Supervised>,
    /// How often each was broken.
    counts: Box<[AtomicU64]>,
    bounds: Indexed<CodelIx, Bound>,
    /// For each state machine, whether steps of it are forbidden; empty if none is of any.
    stepping: Box<[bool]>,
    /// Activities that run, by state machine; empty if no rule asks.
    running: Box<[AtomicU32]>,
    /// Codels that returned before the instance went on from another one.
    before: Indexed<CodelIx, AtomicBool>,
    /// Dates of the calls that were told, by context and rule: each call breaks a rule once.
    claims: Box<[AtomicU64]>,
    /// Windows of the rules about missed ticks.
    windows: Mutex<Vec<Window>>,
    /// Whether a task has one of these.
    alive: Indexed<TaskIx, bool>,
    /// Violations by requests, until control tells them.
    aside: Mutex<Vec<Seen>>,
    cycles: Indexed<TaskIx, CycleBound>,
    /// Date of the end of the start-up; [`u64::MAX`] before.
    opened: AtomicU64,
    /// Heartbeats, orders and formulas.
    hearing: Hearing,
}

impl Rules {
    /// Those of an instance; whether it goes on from another one.
    pub(crate) fn new(plan: &Plan, all: Vec<Supervised>, resumes: bool) -> Self {
        let model = plan.component();
        let longest = |codel: CodelIx, wcet: u64| {
            let limits = all.iter().flat_map(|one| match &one.rule {
                Rule::Longest { codels } => codels.as_slice(),
                _ => &[],
            });
            let own = limits.filter(|(other, _)| *other == codel);
            own.map(|(_, limit)| nanos(*limit)).chain([wcet]).min().unwrap_or(wcet)
        };
        let ordered = |codel: CodelIx| {
            all.iter().any(|one| match &one.rule {
                Rule::After { codels, .. } | Rule::During { codels, .. } => codels.contains(&codel),
                _ => false,
            })
        };
        let hearing = Hearing::new(Places { model, resumes }, &all);
        let bound = |(ix, codel): (CodelIx, &genom_description::model::Codel)| {
            let wcet = codel.wcet.map_or(u64::MAX, nanos);
            let called = hearing.hears(Happening::Call(ix));
            let returns = hearing.hears(Happening::Return(ix));
            let (writes, ordered) = (hearing.awaits_ports_of(ix), ordered(ix));
            Bound { longest: longest(ix, wcet), wcet, ordered, called, returns, writes }
        };
        let cycle = |task: TaskIx| {
            let limits = all.iter().filter_map(|one| match one.rule {
                Rule::Cycle { task: own, longest } if own == task => Some(nanos(longest)),
                _ => None,
            });
            let heard = hearing.hears(Happening::Cycle(task));
            CycleBound { longest: limits.min().unwrap_or(u64::MAX), heard }
        };
        let cycles = model.tasks.places().map(cycle).collect();
        let bounds = model.codels.pairs().map(bound).collect();
        let machines = plan.machines();
        let steps = |owner: Owner| {
            let is = |one: &Supervised| matches!(&one.rule, Rule::Step { owner: own, .. } if *own == owner);
            all.iter().any(is)
        };
        let stepping: Box<[bool]> = machines.iter().map(|one| steps(one.owner)).collect();
        let stepping = if stepping.contains(&true) { stepping } else { Box::default() };
        let during = all.iter().any(|one| matches!(one.rule, Rule::During { .. }));
        let running = machines.iter().filter(|_| during).map(|_| AtomicU32::new(0)).collect();
        let windows = all.iter().enumerate().filter_map(|(rank, one)| match one.rule {
            Rule::Missed { task, ticks, within } => {
                Some(Window::new(rank, task, ticks, nanos(within)))
            }
            _ => None,
        });
        let windows: Vec<Window> = windows.collect();
        let alive = model.tasks.places().map(|task| windows.iter().any(|one| one.task == task));
        let claims = (0..plan.contexts() * all.len()).map(|_| AtomicU64::new(u64::MAX)).collect();
        Self {
            counts: all.iter().map(|_| AtomicU64::new(0)).collect(),
            bounds,
            stepping,
            running,
            before: model.codels.iter().map(|_| AtomicBool::new(false)).collect(),
            claims,
            alive: alive.collect(),
            windows: Mutex::new(windows),
            aside: Mutex::default(),
            cycles,
            opened: AtomicU64::new(u64::MAX),
            hearing,
            all,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// What a call of this codel is compared with.
    #[inline]
    pub(crate) fn bound(&self, codel: CodelIx) -> Bound {
        self.bounds[codel]
    }

    /// What the cycles of this task are compared with.
    #[inline]
    pub(crate) fn cycle(&self, task: TaskIx) -> CycleBound {
        self.cycles[task]
    }

    /// Whether a cycle that began at this date is one of the start-up.
    pub(super) fn starts_up(&self, since: u64) -> bool {
        since < self.opened.load(Ordering::Acquire)
    }

    /// Tells the rules that a cycle breaks which began at `since`.
    #[cold]
    pub(crate) fn cycled(
        &self,
        task: TaskIx,
        (since, ns, over): (u64, u64, bool),
        mut tell: impl FnMut(usize, Fact),
    ) {
        for (rank, one) in self.all.iter().enumerate() {
            let Rule::Cycle { task: own, longest } = one.rule else { continue };
            let late = own == task && ns > nanos(longest) && !self.starts_up(since);
            if late && self.claim(task.index(), rank, since) {
                tell(rank, Fact::Cycle { task, ns, over });
            }
        }
    }

    /// Who hears of this.
    pub(crate) fn hears(&self, what: Happening) -> Heard {
        self.hearing.hears(what)
    }

    /// The formulas that the thread of this task alone moves on, at their beginning.
    pub(crate) fn own(&self, task: TaskIx) -> Formulas {
        self.hearing.own(task)
    }

    /// Something happens, at a date and by an activity, which these hear of; tells what breaks rules.
    /// `own` are the formulas of the task in whose thread it happens.
    #[inline]
    pub(crate) fn hear(
        &self,
        what: (Happening, u32, u64),
        by: Heard,
        own: &mut Formulas,
        mut tell: impl FnMut(Seen),
    ) {
        if by.own {
            self.hearing.hear_own(what, own, &mut tell);
        }
        if by.others {
            self.hearing.hear(what, tell);
        }
    }

    /// Something happens in the thread of no task.
    pub(crate) fn hear_elsewhere(&self, what: (Happening, u32, u64), tell: impl FnMut(Seen)) {
        self.hearing.hear(what, tell);
    }

    /// A codel of an activity has returned: the ports that it wrote.
    pub(crate) fn wrote(
        &self,
        body: &dyn Body,
        codel: CodelIx,
        activity: u32,
        date: u64,
        own: Option<&mut Formulas>,
        tell: impl FnMut(Seen),
    ) {
        self.hearing.wrote(body, codel, activity, date, own, tell);
    }

    /// What broke rules, of what threads left to others.
    pub(super) fn take_left(&self) -> Vec<Seen> {
        self.hearing.take_left()
    }

    /// What happened and was not heard, since too many threads were in the way.
    pub(crate) fn unheard(&self) -> u64 {
        self.hearing.lost()
    }

    /// From this date on heartbeats are waited for, and cycles are looked at that begin then.
    pub(crate) fn await_beats(&self, now: u64) {
        self.opened.store(now, Ordering::Release);
        self.hearing.begin(now);
    }

    /// Heartbeats that are too late at this date.
    pub(super) fn late(&self, now: u64) -> Vec<(usize, Fact)> {
        self.hearing.late(now)
    }

    pub(super) fn next_beat(&self) -> Option<u64> {
        self.hearing.due()
    }

    /// The service during whose activities a heartbeat is waited for.
    pub(super) fn during(&self, rule: usize) -> Option<ServiceIx> {
        match self.all.get(rule)?.rule {
            Rule::Beat { during, .. } => during,
            _ => None,
        }
    }

    /// Whether control has to know when the task misses a tick.
    pub(crate) fn watches_ticks(&self, task: TaskIx) -> bool {
        self.alive[task]
    }

    pub(super) fn windows(&self) -> Guard<'_, Vec<Window>> {
        lock(&self.windows)
    }

    /// How often a rule was broken.
    pub(crate) fn count(&self, rule: usize) -> u64 {
        self.counts.get(rule).map_or(0, |count| count.load(Ordering::Relaxed))
    }

    /// How often each rule was broken.
    pub(crate) fn counts(&self) -> Vec<u64> {
        (0..self.all.len()).map(|rule| self.count(rule)).collect()
    }

    /// Counts a violation.
    pub(crate) fn counted(&self, seen: Seen) -> Seen {
        self.counts[seen.rule].fetch_add(1, Ordering::Relaxed);
        seen
    }

    /// Whether this call, identified by its date, has not been told for this rule yet.
    pub(super) fn claim(&self, context: usize, rule: usize, since: u64) -> bool {
        let place = context * self.all.len() + rule;
        self.claims.get(place).is_some_and(|last| last.swap(since, Ordering::AcqRel) != since)
    }

    /// Keeps a violation of a request for control.
    pub(crate) fn set_aside(&self, seen: Seen) {
        let mut aside = lock(&self.aside);
        if aside.len() < MOST_ASIDE {
            aside.push(seen);
        }
    }

    pub(crate) fn take_aside(&self) -> Vec<Seen> {
        std::mem::take(&mut *lock(&self.aside))
    }

    /// A service was executed before the instance went on from another one: so were its codels, of
    /// an activity those of state `start`.
    pub(crate) fn has_run(&self, plan: &Plan, service: ServiceIx) {
        let (model, start) = (plan.component(), plan.component().state("start"));
        let first = |codel: &&CodelIx| match &model.codels[**codel].kind {
            CodelKind::Fsm { triggers, .. } => start.is_some_and(|start| triggers.contains(&start)),
            CodelKind::Validate | CodelKind::Simple => true,
        };
        let Some(service) = model.services.get(service) else { return };
        for &codel in service.validates.iter().chain(&service.codels).filter(first) {
            self.before[codel].store(true, Ordering::Relaxed);
        }
    }

    /// An activity begins to run.
    pub(crate) fn begins(&self, machine: usize) {
        if let Some(running) = self.running.get(machine) {
            running.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// An activity that ran has ended.
    pub(crate) fn ends(&self, machine: usize) {
        if let Some(running) = self.running.get(machine) {
            running.fetch_sub(1, Ordering::AcqRel);
        }
    }

    /// Whether steps of a state machine are looked at.
    #[inline]
    pub(crate) fn looks_at_steps(&self, machine: usize) -> bool {
        self.stepping.get(machine).copied().unwrap_or(false)
    }

    /// Tells the rules that a step breaks.
    #[cold]
    pub(crate) fn stepped(
        &self,
        machine_owner: Owner,
        (from, to): (StateIx, StateIx),
        mut tell: impl FnMut(usize, Fact),
    ) {
        for (rank, one) in self.all.iter().enumerate() {
            if one.rule == (Rule::Step { owner: machine_owner, from, to }) {
                tell(rank, Fact::Step { from, to });
            }
        }
    }

    /// Tells the rules that a call of this codel breaks by its order. `has_run`: whether a codel has
    /// returned since the start.
    #[cold]
    pub(crate) fn called(
        &self,
        plan: &Plan,
        codel: CodelIx,
        has_run: impl Fn(CodelIx) -> bool,
        mut tell: impl FnMut(usize, Fact),
    ) {
        let did = |codel| has_run(codel) || self.before[codel].load(Ordering::Relaxed);
        for (rank, one) in self.all.iter().enumerate() {
            match &one.rule {
                Rule::After { codels, first }
                    if codels.contains(&codel) && !first.iter().any(|&first| did(first)) =>
                {
                    if let Some(&first) = first.first() {
                        tell(rank, Fact::Early { codel, first });
                    }
                }
                Rule::During { codels, service }
                    if codels.contains(&codel) && self.runs(plan, *service) =>
                {
                    tell(rank, Fact::During { codel, service: *service });
                }
                _ => {}
            }
        }
    }

    fn runs(&self, plan: &Plan, service: ServiceIx) -> bool {
        let machine = plan.services().get(service).and_then(|service| service.machine);
        let running = machine.and_then(|machine| self.running.get(machine));
        running.is_some_and(|running| running.load(Ordering::Acquire) > 0)
    }

    /// Tells the rules that a call which returned breaks by its duration. It began at `since` in
    /// this context.
    #[cold]
    pub(crate) fn returned(
        &self,
        codel: CodelIx,
        ns: u64,
        (context, since): (usize, u64),
        mut tell: impl FnMut(usize, Fact),
    ) {
        for (rank, one) in self.all.iter().enumerate() {
            let Rule::Longest { codels } = &one.rule else { continue };
            let late = |(own, limit): &(CodelIx, _)| *own == codel && ns > nanos(*limit);
            if codels.iter().any(late) && self.claim(context, rank, since) {
                tell(rank, Fact::Took { codel, ns });
            }
        }
    }

    /// For each rule about activities of this service that counts for one that was accepted and
    /// perhaps asked to stop at these dates: its index, the date from which it counts, and the limit
    /// in nanoseconds.
    pub(super) fn of_activity(
        &self,
        service: ServiceIx,
        accepted: u64,
        asked: Option<u64>,
    ) -> impl Iterator<Item = (usize, u64, u64)> {
        self.all.iter().enumerate().filter_map(move |(rank, one)| match one.rule {
            Rule::Activity { service: own, longest } if own == service => {
                Some((rank, accepted, nanos(longest)))
            }
            Rule::Stop { service: own, longest } if own == service => {
                Some((rank, asked?, nanos(longest)))
            }
            _ => None,
        })
    }
}
