//! Priority inheritance: whoever runs what a more urgent context waits for becomes as urgent.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};

use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
};

use super::IDLE;

/// Priorities of the threads behind the contexts.
#[derive(Debug)]
pub struct Inheritance {
    /// Whether any context is real-time; otherwise there is nothing to lend, nor to note.
    enabled: AtomicBool,
    contexts: Box<[Context]>,
}

#[derive(Debug)]
struct Context {
    /// What it runs now; noted only when there is something to lend.
    node: AtomicU32,
    /// `SCHED_FIFO` priority of its thread, 0 when it is not real-time.
    own: AtomicI32,
    /// What it was lent, 0 for nothing.
    lent: AtomicI32,
    /// Its thread; contexts without thread are never lent anything.
    thread: OnceLock<thread_priority::ThreadId>,
}

impl Inheritance {
    pub(super) fn new(contexts: usize) -> Self {
        let context = || Context {
            node: AtomicU32::new(IDLE),
            own: AtomicI32::new(0),
            lent: AtomicI32::new(0),
            thread: OnceLock::new(),
        };
        Self {
            enabled: AtomicBool::new(false),
            contexts: (0..contexts).map(|_| context()).collect(),
        }
    }

    /// The calling thread is `context`'s for good, with this `SCHED_FIFO` priority (0: none).
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

    /// Lends `context`'s priority to those that hold it up. Called under the guard.
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
            if set_fifo(*thread, priority) {
                other.lent.store(priority, Ordering::Relaxed);
            }
        }
    }

    /// What was lent goes back. Called under the guard, by `context`'s own thread.
    pub(super) fn give_back(&self, context: usize) {
        let context = &self.contexts[context];
        if context.lent.swap(0, Ordering::Relaxed) == 0 {
            return;
        }
        let Some(thread) = context.thread.get() else { return };
        match context.own.load(Ordering::Relaxed) {
            0 => {
                let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
                let Ok(middle) = 50u8.try_into() else { return };
                let priority = ThreadPriority::Crossplatform(middle);
                let _ = thread_priority::set_thread_priority_and_policy(*thread, priority, policy);
            }
            own => {
                set_fifo(*thread, own);
            }
        }
    }
}

/// Makes a thread real-time with this `SCHED_FIFO` priority; `false` when that is not allowed.
pub(crate) fn set_fifo(thread: thread_priority::ThreadId, priority: i32) -> bool {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let Ok(percent) = u8::try_from(priority.clamp(1, 99)) else { return false };
    let Ok(value) = percent.try_into() else { return false };
    let priority = ThreadPriority::Crossplatform(value);
    thread_priority::set_thread_priority_and_policy(thread, priority, policy).is_ok()
}
