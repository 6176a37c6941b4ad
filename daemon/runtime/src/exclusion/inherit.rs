//! Priority inheritance: a context that blocks a more urgent one runs with the priority of that
//! one.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};

use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
};

use super::node::IDLE;

/// Priorities of the threads that run the contexts.
#[derive(Debug)]
pub struct Inheritance {
    /// Whether any context is real-time; otherwise there is no priority to lend, and nothing is
    /// recorded.
    enabled: AtomicBool,
    contexts: Box<[Context]>,
    /// Sets the `SCHED_FIFO` priority of a thread; 0 for normal scheduling.
    schedule: Schedule,
}

/// Changes a thread's scheduling; `false` when that is not allowed.
type Schedule = fn(thread_priority::ThreadId, i32) -> bool;

#[derive(Debug)]
struct Context {
    /// The node it runs; recorded only if a context is real-time.
    node: AtomicU32,
    /// `SCHED_FIFO` priority of its thread, 0 if not real-time.
    own: AtomicI32,
    /// Priority that it was lent, 0 for none.
    lent: AtomicI32,
    /// Its thread; contexts without a thread are not lent priorities.
    thread: OnceLock<thread_priority::ThreadId>,
}

impl Inheritance {
    pub(super) fn new(contexts: usize) -> Self {
        Self::with(contexts, set_priority)
    }

    fn with(contexts: usize, schedule: Schedule) -> Self {
        let context = || Context {
            node: AtomicU32::new(IDLE),
            own: AtomicI32::new(0),
            lent: AtomicI32::new(0),
            thread: OnceLock::new(),
        };
        Self {
            enabled: AtomicBool::new(false),
            contexts: (0..contexts).map(|_| context()).collect(),
            schedule,
        }
    }

    /// Assigns the calling thread to `context` for ever, with this `SCHED_FIFO` priority (0: none).
    pub fn announce(&self, context: usize, priority: i32) {
        let Some(context) = self.contexts.get(context) else { return };
        let _ = context.thread.set(thread_priority::thread_native_id());
        context.own.store(priority, Ordering::Relaxed);
        if priority > 0 {
            self.enabled.store(true, Ordering::Relaxed);
        }
    }

    #[inline]
    pub(super) fn runs(&self, context: usize, node: u32) {
        if self.enabled.load(Ordering::Relaxed) {
            self.contexts[context].node.store(node, Ordering::Release);
        }
    }

    /// Lends the priority of `context` to those that block it. Called under the guard.
    pub(super) fn lend(&self, context: usize, holds_up: impl Fn(usize, u32) -> bool) {
        let mine = &self.contexts[context];
        let priority = mine.own.load(Ordering::Relaxed).max(mine.lent.load(Ordering::Relaxed));
        if priority == 0 || !self.enabled.load(Ordering::Relaxed) {
            return;
        }
        for (rank, other) in self.contexts.iter().enumerate() {
            let node = other.node.load(Ordering::Acquire);
            let has = other.own.load(Ordering::Relaxed).max(other.lent.load(Ordering::Relaxed));
            if rank == context || node == IDLE || has >= priority || !holds_up(rank, node) {
                continue;
            }
            let Some(thread) = other.thread.get() else { continue };
            if (self.schedule)(*thread, priority) {
                other.lent.store(priority, Ordering::Relaxed);
            }
        }
    }

    /// Returns a lent priority. Called under the guard, by the thread of `context` itself.
    pub(super) fn give_back(&self, context: usize) {
        let context = &self.contexts[context];
        if context.lent.swap(0, Ordering::Relaxed) == 0 {
            return;
        }
        if let Some(thread) = context.thread.get() {
            (self.schedule)(*thread, context.own.load(Ordering::Relaxed));
        }
    }
}

fn set_priority(thread: thread_priority::ThreadId, priority: i32) -> bool {
    if priority > 0 {
        return set_fifo(thread, priority);
    }
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    let Ok(middle) = 50u8.try_into() else { return false };
    let priority = ThreadPriority::Crossplatform(middle);
    thread_priority::set_thread_priority_and_policy(thread, priority, policy).is_ok()
}

/// Makes a thread real-time with this `SCHED_FIFO` priority; `false` when that is not allowed.
pub(crate) fn set_fifo(thread: thread_priority::ThreadId, priority: i32) -> bool {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let Ok(percent) = u8::try_from(priority.clamp(1, 99)) else { return false };
    let Ok(value) = percent.try_into() else { return false };
    let priority = ThreadPriority::Crossplatform(value);
    thread_priority::set_thread_priority_and_policy(thread, priority, policy).is_ok()
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex, mpsc};

    use super::*;
    use crate::exclusion::Exclusion;
    use crate::plan::Nodes;

    static CHANGES: Mutex<Vec<i32>> = Mutex::new(Vec::new());

    fn note(_: thread_priority::ThreadId, priority: i32) -> bool {
        CHANGES.lock().unwrap().push(priority);
        true
    }

    #[test]
    fn whoever_holds_up_a_real_time_context_has_its_priority_until_it_leaves() {
        // 2 waits for 1, which waits for 0: context 0 is lent the priority of context 2.
        let nodes = Nodes::of_pairs(3, &[(0, 1), (1, 2)]);
        let mut exclusion = Exclusion::new(&nodes, 3);
        exclusion.inheritance = Inheritance::with(3, note);
        let exclusion = Arc::new(exclusion);
        // Enabled from the start, as in an instance with a real-time task.
        exclusion.inheritance().enabled.store(true, Ordering::Relaxed);
        let (entered, enters) = mpsc::channel();
        let (leave, leaves) = mpsc::channel::<()>();
        let run = |context: usize, priority: i32| {
            let (exclusion, entered) = (Arc::clone(&exclusion), entered.clone());
            move || {
                exclusion.inheritance().announce(context, priority);
                let permit = exclusion.enter(context, context);
                entered.send(context).unwrap();
                permit.waited()
            }
        };
        let low = {
            let run = Arc::clone(&exclusion);
            let entered = entered.clone();
            std::thread::spawn(move || {
                run.inheritance().announce(0, 0);
                let _permit = run.enter(0, 0);
                entered.send(0).unwrap();
                leaves.recv().unwrap();
            })
        };
        assert_eq!(enters.recv().unwrap(), 0);
        let middle = std::thread::spawn(run(1, 0));
        let begin = std::time::Instant::now();
        let wait = || {
            assert!(begin.elapsed().as_secs() < 30, "nothing happens");
            std::thread::yield_now();
        };
        while !exclusion.is_waiting(1) {
            wait();
        }
        let high = std::thread::spawn(run(2, 40));
        while CHANGES.lock().unwrap().is_empty() {
            wait();
        }
        leave.send(()).unwrap();
        low.join().unwrap();
        assert!(middle.join().unwrap() && high.join().unwrap());
        // Lent and returned; context 1 may have been lent it too, once it ran.
        let changes = CHANGES.lock().unwrap().clone();
        assert!(changes == [40, 0] || changes == [40, 0, 40, 0], "{changes:?}");
    }
}
