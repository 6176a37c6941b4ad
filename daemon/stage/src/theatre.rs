//! Holds threads until it is their turn, and moves the clock.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use genom_description::model::CodelIx;
use genom_runtime::body::Returned;
use genom_runtime::{OnStage, Stage, Turn};

/// How long threads may take, by the machine's clock, until they wait again. Nothing that they do
/// meanwhile takes long.
const PATIENCE: Duration = Duration::from_secs(20);
/// Interval of looking at threads that wait for each other: they tell nobody.
const LOOK: Duration = Duration::from_micros(200);

/// A thread that waits for its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Waiting {
    /// Before a pass, or before control's next round.
    Turn(Turn),
    /// In a codel.
    Codel { codel: CodelIx, context: usize },
}

/// Holds the threads of one instance.
#[derive(Default)]
pub(crate) struct Theatre {
    /// Read by threads that may hold locks of the runtime, so it has none.
    now: AtomicU64,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Threads that wait, with their numbers.
    waiting: Vec<(u64, Waiting)>,
    /// Threads whose turn it is, and what their codels return.
    called: Vec<(u64, Option<Returned>)>,
    next: u64,
    /// Everything goes on by itself.
    open: bool,
    /// The start of the component is over: all its threads have been here.
    started: bool,
    /// Tasks that have a thread.
    tasks: BTreeSet<usize>,
    /// Contexts that have executed a codel.
    executed: BTreeSet<usize>,
    /// Tasks that have made their first pass: they wait for another one.
    begun: BTreeSet<usize>,
    instance: Option<Weak<dyn OnStage>>,
}

impl State {
    /// Whether nobody goes on before somebody's turn: each thread waits here, or for a codel of one
    /// that does.
    fn is_quiet(&self) -> bool {
        let Some(instance) = self.instance.as_ref().and_then(Weak::upgrade) else { return false };
        if !self.called.is_empty() {
            return false;
        }
        let here = |context: usize| {
            self.waiting.iter().any(|(_, one)| match *one {
                Waiting::Turn(Turn::Pass { task, .. }) => task == context,
                Waiting::Turn(Turn::Control) => false,
                Waiting::Codel { context: own, .. } => own == context,
            })
        };
        let blocked = instance.blocked();
        let all = self.tasks.iter().all(|task| here(*task) || blocked.contains(task));
        let of_control = |context: usize| !self.tasks.contains(&context);
        let codels = self.waiting.iter().filter(
            |(_, one)| matches!(one, Waiting::Codel { context, .. } if of_control(*context)),
        );
        let requests = codels.count() + blocked.iter().filter(|one| of_control(**one)).count();
        let control = || self.waiting.iter().any(|(_, one)| *one == Waiting::Turn(Turn::Control));
        all && (!self.started || control()) && instance.serving() == requests
    }
}

impl fmt::Debug for Theatre {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Theatre({} ns)", self.now())
    }
}

impl Theatre {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ticks that each task has missed by now.
    pub(crate) fn missed(&self) -> Vec<u64> {
        let instance = self.lock().instance.as_ref().and_then(Weak::upgrade);
        instance.map_or_else(Vec::new, |instance| instance.missed())
    }

    /// Sets the clock.
    pub(crate) fn set(&self, now: u64) {
        self.now.store(now, Ordering::Release);
    }

    /// Whether so many tasks have made their first passes, once nobody goes on before a turn.
    pub(crate) fn have_begun(&self, tasks: usize) -> bool {
        let begun = |state: &State| state.begun.len() == tasks;
        let look = |state: &State| (begun(state) || state.is_quiet()).then(|| begun(state));
        self.until(look).unwrap_or(false)
    }

    /// The start of the component is over.
    pub(crate) fn started(&self) {
        self.lock().started = true;
        self.changed.notify_all();
    }

    /// Lets all threads go on, now and later: nothing is played any more.
    pub(crate) fn open(&self) {
        self.lock().open = true;
        self.changed.notify_all();
    }

    /// A codel is executed; `None` if nothing is played any more.
    pub(crate) fn codel(&self, codel: CodelIx, context: usize) -> Option<Returned> {
        self.hold(Waiting::Codel { codel, context })
    }

    /// Holds the calling thread until its turn.
    fn hold(&self, what: Waiting) -> Option<Returned> {
        let mut state = self.lock();
        match what {
            Waiting::Turn(Turn::Pass { task, .. }) => {
                state.tasks.insert(task);
                if state.executed.contains(&task) {
                    state.begun.insert(task);
                }
            }
            Waiting::Codel { context, .. } => _ = state.executed.insert(context),
            Waiting::Turn(Turn::Control) => {}
        }
        let number = state.next;
        state.next += 1;
        state.waiting.push((number, what));
        self.changed.notify_all();
        loop {
            if let Some(at) = state.called.iter().position(|(called, _)| *called == number) {
                let (_, returned) = state.called.swap_remove(at);
                self.changed.notify_all();
                return returned;
            }
            if state.open {
                state.waiting.retain(|(other, _)| *other != number);
                if matches!(what, Waiting::Turn(_)) {
                    // Time goes on here by the machine's clock, so that nobody spins.
                    drop(self.changed.wait_timeout(state, Duration::from_millis(1)));
                }
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until nobody goes on by himself; `false` when that does not come.
    pub(crate) fn settle(&self) -> bool {
        self.until(|state| state.is_quiet().then_some(())).is_some()
    }

    /// Waits until a thread waits that `wanted` accepts, and lets it go on; `false` if there is none.
    pub(crate) fn call(
        &self,
        wanted: impl Fn(&Waiting) -> bool,
        returned: Option<Returned>,
    ) -> bool {
        let place = |state: &State| state.waiting.iter().position(|(_, one)| wanted(one));
        // At the start of the component, threads come one after another.
        let found = self.until(|state| {
            let nobody = || (state.started && state.is_quiet()).then_some(None);
            place(state).map(Some).or_else(nobody)
        });
        let Some(Some(_)) = found else { return false };
        let mut state = self.lock();
        let Some(at) = place(&state) else { return false };
        let (number, _) = state.waiting.remove(at);
        state.called.push((number, returned));
        drop(state);
        self.changed.notify_all();
        true
    }

    /// The threads that wait.
    pub(crate) fn waiting(&self) -> Vec<Waiting> {
        self.lock().waiting.iter().map(|(_, one)| *one).collect()
    }

    /// Looks again and again until there is an answer, or for as long as threads may take.
    fn until<R>(&self, look: impl Fn(&State) -> Option<R>) -> Option<R> {
        let end = Instant::now() + PATIENCE;
        let mut state = self.lock();
        loop {
            if let Some(found) = look(&state) {
                return Some(found);
            }
            if Instant::now() >= end {
                return None;
            }
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Stage for Theatre {
    fn now(&self) -> u64 {
        self.now.load(Ordering::Acquire)
    }

    fn enters(&self, instance: Weak<dyn OnStage>) {
        self.lock().instance = Some(instance);
    }

    fn wait(&self, turn: Turn) {
        let _ = self.hold(Waiting::Turn(turn));
    }
}
