//! State shared by the control and task threads of an instance, without locks: atomics, the
//! exclusion, figures.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

use genom_description::model::{CodelIx, Indexed, Owner, StateIx, TaskIx};
use rtrb::Producer;

use crate::at_work::AtWork;
use crate::body::{Body, Returned};
use crate::clock::Clock;
use crate::exclusion::{Exclusion, PiLock};
use crate::figures::{CodelFigures, TaskFigures};
use crate::histogram::Counter;
use crate::plan::Plan;
use crate::rules::{Fact, Rules, Seen};
use crate::task::call::Call;
use crate::task::hurry::Hurry;
use crate::task::timing::{RESPONSE, Timing};

/// Shared by the threads of one instance.
pub(crate) struct Shared {
    pub(crate) plan: Arc<Plan>,
    pub(crate) body: Arc<dyn Body>,
    pub(crate) clock: Clock,
    pub(crate) exclusion: Exclusion,
    pub(crate) tasks: Indexed<TaskIx, TaskShared>,
    pub(crate) codels: Indexed<CodelIx, CodelFigures>,
    /// What it is supervised by.
    pub(crate) rules: Rules,
    /// The codel that each context runs.
    pub(crate) at_work: Box<[AtWork]>,
    /// The control thread, once it runs; there is none with a virtual clock.
    pub(crate) control: OnceLock<Thread>,
    /// Reaches the thread that the instance shares with others, if it does.
    pub(crate) call: Option<Arc<Call>>,
    /// Whether there is something for control to process.
    pub(crate) attention: AtomicBool,
    /// Whether a shutdown has begun.
    pub(crate) stopping: AtomicBool,
    /// Tasks make no pass after their first one while this is set.
    pub(crate) held: AtomicBool,
    /// Another instance hands over to this one, which is held until that is done.
    pub(crate) takes_over: AtomicBool,
    /// Locked meanwhile.
    pub(crate) turnstile: PiLock,
    /// Ticks until this date were served by the instance that handed over to this one; 0 if none
    /// did.
    pub(crate) served_before: AtomicU64,
    /// Notices dropped because the ring was full.
    pub(crate) lost: Counter,
}

/// State shared between one task and the other threads.
#[derive(Debug)]
pub(crate) struct TaskShared {
    /// Dates of ticks; `None` for an aperiodic task.
    pub(crate) timing: Option<Timing>,
    pub(crate) figures: TaskFigures,
    /// Whether its thread got a real-time priority.
    pub(crate) real_time: AtomicBool,
    runnable: AtomicBool,
    quit: AtomicBool,
    /// A periodic task sleeps on this, so that a shutdown can wake it before its next tick.
    pub(crate) hurry: Hurry,
    /// Bits of external events that the task has not taken yet.
    fired: Box<[AtomicU64]>,
    /// Whether the first codel of the permanent activity has run.
    started: AtomicBool,
    thread: OnceLock<Thread>,
    /// Reaches the thread in place of `thread` if the task shares it with those of others.
    call: Option<Arc<Call>>,
    /// Thread id of the system; 0 while there is no thread.
    thread_number: AtomicU32,
    /// The thread that waits for `started`.
    starter: OnceLock<Thread>,
}

/// What a task reports to watchers, through control.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Notice {
    Moved { activity: u32, state: StateIx, paused: bool },
    Overrun { task: TaskIx, ticks: u64 },
}

impl Shared {
    pub(crate) fn new(
        plan: &Arc<Plan>,
        body: Arc<dyn Body>,
        clock: Clock,
        timings: Indexed<TaskIx, Option<Timing>>,
        call: Option<Arc<Call>>,
        rules: Rules,
    ) -> Self {
        let model = plan.component();
        let sinks = model.sinks.len().div_ceil(64);
        // One more context, for excluding everything.
        let contexts = plan.contexts() + 1;
        Self {
            body,
            clock,
            exclusion: Exclusion::new(plan.nodes(), contexts),
            tasks: timings
                .into_iter()
                .map(|timing| TaskShared::new(timing, sinks, call.clone()))
                .collect(),
            codels: model.codels.places().map(|ix| CodelFigures::new(plan.yields(ix))).collect(),
            rules,
            at_work: (0..contexts).map(|_| AtWork::default()).collect(),
            control: OnceLock::new(),
            call,
            attention: AtomicBool::new(false),
            stopping: AtomicBool::new(false),
            held: AtomicBool::new(false),
            takes_over: AtomicBool::new(false),
            turnstile: PiLock::default(),
            served_before: AtomicU64::new(0),
            lost: Counter::default(),
            plan: Arc::clone(plan),
        }
    }

    /// Whether the tick that a periodic task serves in a pass at date `now` was served already by
    /// the instance that handed over to this one: a thread that woke late comes to it after that.
    #[inline]
    pub(crate) fn was_served(&self, task: TaskIx, now: u64) -> bool {
        let before = self.served_before.load(Ordering::Acquire);
        let timing = if before == 0 { None } else { self.tasks[task].timing };
        timing.is_some_and(|timing| timing.count(now) <= timing.count(before))
    }

    /// The context that excludes everything; one thread at a time uses it.
    pub(crate) fn outside_context(&self) -> usize {
        self.plan.contexts()
    }

    /// When control work, or a pass of an aperiodic task, is to be done that is asked for at this
    /// date. An instance that stops precedes all others: it takes little, and then leaves them more.
    pub(crate) fn respond_by(&self, now: u64) -> u64 {
        if self.stopping.load(Ordering::Acquire) { now } else { now + RESPONSE }
    }

    /// Records a call of a codel that began at `since` in this context, what it returned, and its
    /// duration. Tells the rules that it breaks by that, with their indices.
    #[inline]
    pub(crate) fn called(
        &self,
        codel: CodelIx,
        (returned, ns): (Returned, u64),
        call: (usize, u64),
        tell: impl FnMut(usize, Fact),
    ) {
        let figures = &self.codels[codel];
        figures.returned(self.plan.yields(codel), returned, ns);
        let bound = self.rules.bound(codel);
        if ns > bound.longest {
            if ns > bound.wcet {
                figures.above_wcet.add(1);
            }
            self.rules.returned(codel, ns, call, tell);
        }
    }

    /// Tells the rules that a call of this codel breaks by its order, before it is made.
    #[inline]
    pub(crate) fn calls(&self, codel: CodelIx, tell: impl FnMut(usize, Fact)) {
        if self.rules.bound(codel).ordered {
            let has_run = |codel: CodelIx| self.codels[codel].durations.totals().0 > 0;
            self.rules.called(&self.plan, codel, has_run, tell);
        }
    }

    /// Counts a violation and sends it to control; when the ring is full it is only counted.
    #[cold]
    pub(crate) fn violated(&self, ring: &mut Option<Producer<Seen>>, seen: Seen) {
        let seen = self.rules.counted(seen);
        if let Some(ring) = ring {
            let _ = ring.push(seen);
        }
        self.wake_control();
    }

    /// The codel that a context runs now.
    pub(crate) fn current(&self, context: usize) -> Option<CodelIx> {
        self.at_work[context].look().map(|(codel, ..)| codel)
    }

    /// genom3.md 7.3.8, 7.4: something happened in the component, so paused tasks run again.
    pub(crate) fn wake_tasks(&self) {
        self.tasks.iter().for_each(TaskShared::wake);
    }

    /// genom3.md 7.4: something happened in this task, which continues by itself.
    pub(crate) fn wake_others(&self, task: TaskIx) {
        let others = self.tasks.pairs().filter(|(other, _)| *other != task);
        others.for_each(|(_, other)| other.wake());
    }

    pub(crate) fn wake_control(&self) {
        if self.attention.swap(true, Ordering::AcqRel) {
            return;
        }
        match (&self.call, self.control.get()) {
            (Some(call), _) => call.ring(),
            (None, Some(thread)) => thread.unpark(),
            (None, None) => {}
        }
    }

    /// The exclusion node under which outputs are read from the IDS when an activity ends.
    pub(crate) fn fetch_node(&self, owner: Owner) -> Option<usize> {
        let Owner::Service(service) = owner else { return None };
        let through = self.plan.services()[service].through_ids;
        through.then(|| self.plan.nodes().transfer(service))
    }

    /// Sends a notice to watchers; counts it as lost when the ring is full.
    pub(crate) fn notify(&self, notices: &mut Option<Producer<Notice>>, notice: Notice) {
        let Some(notices) = notices else { return };
        if notices.push(notice).is_err() {
            self.lost.add(1);
        }
        // Control polls the ring; a system call to wake it would cost more than the delay.
    }
}

impl TaskShared {
    fn new(timing: Option<Timing>, sinks: usize, call: Option<Arc<Call>>) -> Self {
        Self {
            timing,
            figures: TaskFigures::default(),
            real_time: AtomicBool::new(false),
            // The first pass starts the permanent activity.
            runnable: AtomicBool::new(true),
            quit: AtomicBool::new(false),
            hurry: Hurry::default(),
            fired: (0..sinks).map(|_| AtomicU64::new(0)).collect(),
            started: AtomicBool::new(false),
            thread: OnceLock::new(),
            call,
            thread_number: AtomicU32::new(0),
            starter: OnceLock::new(),
        }
    }

    pub(crate) fn wake(&self) {
        self.runnable.store(true, Ordering::Release);
        // A periodic task is woken by its ticks only.
        if self.timing.is_none() {
            self.unpark();
        }
    }

    fn unpark(&self) {
        match (&self.call, self.thread.get()) {
            (Some(call), _) => call.ring(),
            (None, Some(thread)) => thread.unpark(),
            (None, None) => {}
        }
    }

    /// Records the number of the calling thread as that of the task.
    pub(crate) fn set_thread_number(&self) {
        let number = rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs();
        self.thread_number.store(number, Ordering::Relaxed);
    }

    /// Records the calling thread as that of the task.
    pub(crate) fn set_thread(&self) {
        self.set_thread_number();
        let _ = self.thread.set(std::thread::current());
        // Makes up for wake-ups from before there was a thread.
        self.unpark();
    }

    /// Thread id of the system, while there is a thread.
    pub(crate) fn thread_number(&self) -> Option<u32> {
        Some(self.thread_number.load(Ordering::Relaxed)).filter(|number| *number > 0)
    }

    pub(crate) fn set_starter(&self, thread: Thread) {
        let _ = self.starter.set(thread);
    }

    pub(crate) fn first_codel_done(&self) {
        self.started.store(true, Ordering::Release);
        if let Some(thread) = self.starter.get() {
            thread.unpark();
        }
    }

    pub(crate) fn is_started(&self) -> bool {
        self.started.load(Ordering::Acquire)
    }

    pub(crate) fn is_runnable(&self) -> bool {
        self.runnable.load(Ordering::Acquire)
    }

    pub(crate) fn take_runnable(&self) -> bool {
        self.is_runnable() && self.runnable.swap(false, Ordering::AcqRel)
    }

    pub(crate) fn quits(&self) -> bool {
        self.quit.load(Ordering::Acquire)
    }

    pub(crate) fn quit(&self) {
        self.quit.store(true, Ordering::Release);
        self.hurry();
    }

    /// Wakes the task, also before its next tick.
    pub(crate) fn hurry(&self) {
        self.runnable.store(true, Ordering::Release);
        match self.timing {
            Some(_) => {
                self.hurry.get_up();
                if let Some(call) = &self.call {
                    call.ring();
                }
            }
            None => self.unpark(),
        }
    }

    /// Wakes the task early only if its next tick may be far away: a control loop that brings an
    /// axis to a stop has to keep its period.
    pub(crate) fn hurry_if_slow(&self) {
        /// A tick within this time, in nanoseconds, is waited for.
        const SOON: u64 = 100_000_000;
        if self.timing.is_none_or(|timing| timing.period > SOON) {
            self.hurry();
        }
    }

    /// Fires the external event with this index.
    pub(crate) fn fire(&self, sink: usize) {
        if let Some(word) = self.fired.get(sink / 64) {
            word.fetch_or(1 << (sink % 64), Ordering::AcqRel);
        }
        self.wake();
    }

    /// Takes the states of the external events fired since the last call.
    #[inline]
    pub(crate) fn take_fired(&self, plan: &Plan, into: &mut Vec<StateIx>) {
        into.clear();
        for (word, bits) in self.fired.iter().enumerate() {
            if bits.load(Ordering::Relaxed) == 0 {
                continue;
            }
            let mut bits = bits.swap(0, Ordering::AcqRel);
            while bits != 0 {
                let sink = word * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                into.extend(plan.component().sinks.get(sink).map(|sink| sink.state));
            }
        }
    }
}
