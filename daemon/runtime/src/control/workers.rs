//! The worker threads that serve requests, and the control thread, which collects results of tasks.
//!
//! With [`Execution::Single`](crate::Execution::Single) the shared thread does the work of both. On a
//! virtual clock there are none: the thread that sends a request, or steps the clock, does the
//! work.

use std::sync::Arc;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Duration;

use genom_description::model::ServiceIx;

use super::{Control, Phase, state_port::PERIOD_NS};
use crate::clock::{Clock, Turn};
use crate::engine::{Engine, OVER};
use crate::plan::Builtin;

/// Interval of polling for changes that interest watchers, while activities run.
pub(crate) const LOOK: Duration = Duration::from_millis(50);
/// Stack of control threads, which run validate codels and functions, in bytes.
const STACK: usize = 8 << 20;

impl Engine {
    /// Makes sure that a worker serves the requests that are ready.
    pub(crate) fn find_worker(self: &Arc<Self>) {
        if self.driven.is_some() {
            return self.serve_here();
        }
        if let Some(executor) = &self.single {
            // A codel on the shared thread may wait for this request.
            if executor.is_here() {
                return self.serve_here();
            }
            if let Some(call) = &self.shared.call {
                call.ring();
            }
            return;
        }
        let mut control = self.lock();
        if control.ready.len() > control.idle {
            // All contexts are in use: the first worker that is free takes the request.
            let Some(context) = control.contexts.pop() else { return };
            let (engine, rank) = (Arc::clone(self), control.workers.len());
            let name = format!("{}:control-{rank}", self.name);
            let thread = std::thread::Builder::new().name(name).stack_size(STACK);
            match thread.spawn(move || engine.serve_until_stopped(context)) {
                Ok(worker) => {
                    control.alive += 1;
                    control.workers.push(worker);
                }
                Err(error) => {
                    // The thread could not be created; other workers serve the request later, if
                    // there are any.
                    control.contexts.push(context);
                    tracing::error!(instance = self.name, "no control thread: {error}");
                }
            }
        }
        drop(control);
        self.work.notify_one();
    }

    /// Serves all requests that are ready, on this thread.
    fn serve_here(self: &Arc<Self>) {
        while self.serve_next() {}
    }

    /// Serves the first request that is ready, on this thread; `false` when there is none.
    pub(crate) fn serve_next(self: &Arc<Self>) -> bool {
        let mut control = self.lock();
        let Some(context) = control.contexts.pop() else { return false };
        let next = control.ready.pop_front();
        if let Some(service) = next {
            if self.single.is_some() && self.may_take_long(service) {
                drop(control);
                self.serve_aside(service, context);
                return true;
            }
            control = self.serve_one(control, service, context);
        }
        control.contexts.push(context);
        next.is_some()
    }

    /// Whether a service waits for middlewares: the tasks of a shared thread must not.
    fn may_take_long(&self, service: ServiceIx) -> bool {
        let builtin = self.shared.plan.services()[service].builtin;
        matches!(builtin, Some(Builtin::ConnectPort | Builtin::ConnectService))
    }

    /// Serves a request in a thread of its own. It runs no codel.
    fn serve_aside(self: &Arc<Self>, service: ServiceIx, context: usize) {
        let engine = Arc::clone(self);
        self.lock().alive += 1;
        let aside = std::thread::Builder::new().name(format!("{}:connect", self.name));
        let spawned = aside.spawn(move || {
            let mut control = engine.serve_one(engine.lock(), service, context);
            control.contexts.push(context);
            drop(control);
            engine.shared.wake_control();
            engine.thread_ended();
        });
        match spawned {
            Ok(thread) => {
                let mut control = self.lock();
                control.workers.retain(|worker| !worker.is_finished());
                control.workers.push(thread);
            }
            Err(error) => {
                tracing::error!(instance = self.name, "no thread to connect in: {error}");
                let control = self.lock();
                let mut control = self.serve_one(control, service, context);
                control.contexts.push(context);
                control.alive -= 1;
            }
        }
    }

    /// Whether control has to look every [`LOOK`]: nothing rings for what it looks for then.
    pub(crate) fn looks_often(&self, control: &Control) -> bool {
        let activities = || control.entries.iter().any(|entry| entry.service.is_some());
        // No event signals that a codel has become stuck, so a shutdown is polled.
        control.step.is_some() || (self.watcher.is_some() && activities())
    }

    fn serve_until_stopped(&self, context: usize) {
        self.shared.exclusion.inheritance().announce(context, 0);
        let mut control = self.lock();
        while control.phase != Phase::Stopped {
            control = match control.ready.pop_front() {
                Some(service) => {
                    let control = self.serve_one(control, service, context);
                    if !control.ready.is_empty() {
                        self.work.notify_one();
                    }
                    control
                }
                None => {
                    control.idle += 1;
                    let mut control =
                        self.work.wait(control).unwrap_or_else(PoisonError::into_inner);
                    control.idle -= 1;
                    control
                }
            };
        }
        drop(control);
        self.thread_ended();
    }

    /// The control thread: collects results of tasks until the instance has stopped.
    pub(crate) fn attend_until_stopped(&self) {
        loop {
            let (often, late) = {
                let control = self.lock();
                (self.looks_often(&control), self.next_late(&control))
            };
            let period = if often { LOOK } else { Duration::from_nanos(PERIOD_NS) };
            let left = late.map(|late| late.saturating_sub(self.shared.clock.now()));
            let period = left.map_or(period, |left| period.min(Duration::from_nanos(left)));
            if let Clock::Staged(stage) = &self.shared.clock {
                stage.wait(Turn::Control);
            } else if !self.shared.attention.load(Ordering::Acquire) {
                std::thread::park_timeout(period);
            }
            self.attend();
            self.advance_shutdown();
            self.refresh_state();
            self.rounds.fetch_add(1, Ordering::Relaxed);
            if self.lock().phase == Phase::Stopped {
                self.rounds.store(OVER, Ordering::Relaxed);
                return;
            }
        }
    }
}
