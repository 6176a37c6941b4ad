//! The worker threads that serve requests, and the control thread, which collects results of tasks.
//!
//! On a virtual clock there are none: the thread that sends a request, or steps the clock, does the
//! work.

use std::sync::Arc;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Duration;

use super::{Phase, state_port::PERIOD_NS};
use crate::engine::{Engine, OVER};

/// Interval of polling for changes that interest watchers, while activities run.
const LOOK: Duration = Duration::from_millis(50);
/// Stack of control threads, which run validate codels and functions, in bytes.
const STACK: usize = 8 << 20;

impl Engine {
    /// Makes sure that a worker serves the requests that are ready.
    pub(crate) fn find_worker(self: &Arc<Self>) {
        if self.driven.is_some() {
            return self.serve_here();
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
    fn serve_here(&self) {
        let mut control = self.lock();
        while let Some(context) = control.contexts.pop() {
            let next = control.ready.pop_front();
            if let Some(service) = next {
                control = self.serve_one(control, service, context);
            }
            control.contexts.push(context);
            if next.is_none() {
                break;
            }
        }
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
            let often = {
                let control = self.lock();
                let activities = || control.entries.iter().any(|entry| entry.service.is_some());
                // No event signals that a codel has become stuck, so a shutdown is polled.
                control.step.is_some() || (self.watcher.is_some() && activities())
            };
            let period = if often { LOOK } else { Duration::from_nanos(PERIOD_NS) };
            if !self.shared.attention.load(Ordering::Acquire) {
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
