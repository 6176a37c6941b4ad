//! Shutdown (genom3.md 7.7).

use std::sync::atomic::Ordering;
use std::sync::{Mutex, TryLockError};
use std::time::{Duration, Instant};

use genom_description::model::{Ix as _, TaskIx};

use crate::api::{OnShutdown, Outcome, Progress};
use crate::control::{Afterwards, Control, Entry, Phase, Stage, Step, interrupted};
use crate::engine::Engine;
use crate::lock::lock;
use crate::running::{RunningCodel, seconds};

/// An instance did not shut down in time. It serves no requests any more; threads that hang are
/// left behind with the memory they use, and other instances are not affected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{instance} does not stop: {}", list(.codels, .activities))]
pub struct ShutdownError {
    /// Name of the instance.
    pub instance: String,
    /// Codels that have not returned.
    pub codels: Vec<RunningCodel>,
    /// Activities that have not ended.
    pub activities: Vec<String>,
}

fn list(codels: &[RunningCodel], activities: &[String]) -> String {
    if codels.is_empty() {
        return format!("activities {} do not end after a stop request", activities.join(", "));
    }
    let told = codels.iter().map(|one| {
        let time = seconds(one.for_ns);
        format!("codel {} of {} has been running for {time}", one.codel, one.owner)
    });
    told.collect::<Vec<_>>().join(", ")
}

impl Engine {
    /// Stops activities, then permanent ones, then threads, and waits for the end of all.
    pub(crate) fn shutdown(&self, timeout: Duration) -> Result<(), ShutdownError> {
        let deadline = Instant::now() + timeout;
        if !self.begin_shutdown(None, deadline) {
            return Ok(());
        }
        self.finish_shutdown(deadline)
    }

    /// Begins a shutdown and returns; the control thread does the rest. `false` when a shutdown had
    /// begun before. On a virtual clock everything is done here, since this thread runs the codels.
    pub(crate) fn begin_shutdown(&self, ended: Option<OnShutdown>, deadline: Instant) -> bool {
        if !self.stop_activities(ended) {
            return false;
        }
        if self.driven.is_some() {
            self.drive_shutdown(deadline);
        }
        self.shared.wake_control();
        true
    }

    /// Waits for the end of a shutdown; what hangs at the deadline is left behind.
    pub(crate) fn finish_shutdown(&self, deadline: Instant) -> Result<(), ShutdownError> {
        let over = |control: &Control| control.phase == Phase::Stopped && control.alive == 0;
        if self.wait(deadline, over) {
            self.join();
            return Ok(());
        }
        let error = self.what_hangs();
        self.answer_all();
        // Tasks that hang cannot run their `stop` codels; all others had the time to.
        self.end_threads();
        Err(error)
    }

    /// Whether the shutdown is complete: no codel runs, and none will. On a virtual clock the thread
    /// that steps it may still be in one.
    pub(crate) fn is_over(&self) -> bool {
        let free = |tasks: &Mutex<_>| !matches!(tasks.try_lock(), Err(TryLockError::WouldBlock));
        let control = self.lock();
        control.phase == Phase::Stopped
            && control.alive == 0
            && self.driven.as_ref().is_none_or(free)
    }

    /// Takes the steps of a shutdown that are possible now. Called by the control thread, which
    /// collects results; before that runs, by the thread that waits for the end.
    pub(crate) fn advance_shutdown(&self) {
        // One step must not be taken by two threads.
        let _one = lock(&self.advancing);
        loop {
            let next = {
                let mut control = self.lock();
                let Some(step) = control.step else { return };
                if !self.is_done(&control, step) {
                    return;
                }
                let tasks = || self.shared.tasks.places();
                let permanent = |task: Option<TaskIx>| task.map_or(Step::Rest, Step::Permanent);
                let next = match step {
                    Step::Activities => permanent(tasks().next_back()),
                    Step::Permanent(task) => permanent(tasks().rfind(|before| *before < task)),
                    Step::Rest => Step::Threads,
                    Step::Threads => return,
                };
                control.step = Some(next);
                next
            };
            match next {
                Step::Permanent(task) => self.stop_permanent(task),
                Step::Threads => return self.end_threads(),
                Step::Activities | Step::Rest => {}
            }
        }
    }

    /// Whether a step is complete. Codels that hang are not waited for, so that the `stop` codels
    /// of other tasks still run before the deadline.
    fn is_done(&self, control: &Control, step: Step) -> bool {
        let hangs = |task| self.codel_of_task(task).is_some_and(|codel| codel.stuck);
        match step {
            Step::Activities => {
                let left = control.entries.iter().filter(|entry| entry.service.is_some());
                let hang = |codels: Vec<RunningCodel>| {
                    codels.iter().filter(|codel| codel.stuck && codel.task.is_none()).count()
                };
                left.into_iter().all(|entry| hangs(entry.task))
                    && (control.serving == 0 || control.serving <= hang(self.running_codels()))
            }
            Step::Permanent(task) => {
                control.entries.iter().all(|entry| entry.task != task) || hangs(task)
            }
            Step::Rest => control.entries.is_empty() && control.serving == 0,
            Step::Threads => true,
        }
    }

    /// genom3.md 7.7.3: nothing is served or executed any more.
    fn end_threads(&self) {
        self.shared.tasks.iter().for_each(crate::shared::TaskShared::quit);
        self.lock().phase = Phase::Stopped;
        self.work.notify_all();
        self.shared.wake_control();
        self.tell_end();
    }

    /// Records the end of a thread that ran codels.
    pub(crate) fn thread_ended(&self) {
        self.lock().alive -= 1;
        self.tell_end();
    }

    fn tell_end(&self) {
        let ended = {
            let mut control = self.lock();
            let over = control.phase == Phase::Stopped && control.alive == 0;
            over.then(|| control.ended.take()).flatten()
        };
        self.quiet.notify_all();
        if let Some(ended) = ended {
            ended();
        }
    }

    /// Takes all steps on a virtual clock, where this thread runs the codels.
    pub(crate) fn drive_shutdown(&self, deadline: Instant) {
        let reached =
            |step: Step| self.drive_until(deadline, |engine| engine.is_done(&engine.lock(), step));
        reached(Step::Activities);
        for task in self.shared.tasks.places().rev() {
            self.stop_permanent(task);
            reached(Step::Permanent(task));
        }
        // Otherwise `finish_shutdown` reports what hangs.
        let over = self.is_done(&self.lock(), Step::Rest);
        if over {
            self.end_threads();
        }
    }

    /// genom3.md 7.7.1; `false` when another thread has begun the shutdown before.
    pub(crate) fn stop_activities(&self, ended: Option<OnShutdown>) -> bool {
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            if matches!(control.phase, Phase::Stopping | Phase::Stopped) {
                return false;
            }
            control.phase = Phase::Stopping;
            self.shared.stopping.store(true, Ordering::Release);
            control.step = Some(Step::Activities);
            control.ended = ended;
            control.ready.clear();
            let waiting = control.services.iter_mut().flat_map(|queue| queue.waiting.drain(..));
            let refused = || Progress::Ended(Outcome::Exception(interrupted("kill")));
            after.replies.extend(waiting.map(|request| (request.reply, refused())));
            for at in 0..control.entries.len() {
                if control.entries[at].service.is_some() {
                    self.stop(&mut control, at, "kill", &mut after);
                }
            }
            self.examine(&mut control, &mut after);
        }
        self.finish_off(after);
        // What is held could not run its `stop` codels.
        self.go_on();
        self.shared.tasks.iter().for_each(crate::shared::TaskShared::hurry_if_slow);
        true
    }

    /// Asks a permanent activity to stop. For one that has ended, a new run is made for its `stop`
    /// codel; for one that ends by itself after this, when it is collected.
    fn stop_permanent(&self, task: TaskIx) {
        let asked = {
            let control = self.lock();
            let mut entries = control.entries.iter();
            let permanent =
                |entry: &&crate::control::Entry| entry.task == task && entry.service.is_none();
            // Under the lock: it is collected either before, or with the request.
            entries.find(permanent).map(|entry| entry.marker.request_stop()).is_some()
        };
        if !asked {
            // Without a thread it never ran a codel: there is nothing to undo.
            if !self.has_stop(task) || !self.has_thread(task) {
                return;
            }
            self.send_permanent(task, true);
        }
        self.shared.tasks[task].hurry();
    }

    /// Whether the permanent activity of a task has a `stop` codel.
    pub(crate) fn has_stop(&self, task: TaskIx) -> bool {
        let machine = &self.shared.plan.machines()[task.index()];
        machine.codel(machine.stop).is_some()
    }

    fn has_thread(&self, task: TaskIx) -> bool {
        self.shared.tasks[task].is_started()
    }

    /// Waits until `done`; `false` when the deadline passes.
    fn wait(&self, deadline: Instant, done: impl Fn(&Control) -> bool) -> bool {
        /// Interval of polling while no control thread collects results.
        const LOOK: Duration = Duration::from_millis(10);
        let mut control = self.lock();
        while !done(&control) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            let alone = self.single.is_none() && self.shared.control.get().is_none();
            if alone && self.driven.is_none() {
                drop(control);
                self.attend();
                self.advance_shutdown();
                control = self.lock();
                if done(&control) {
                    return true;
                }
            }
            let slice = if alone { left.min(LOOK) } else { left };
            control = self.quiet.wait_timeout(control, slice);
        }
        true
    }

    /// Answers all open requests with `interrupted`; later results are dropped.
    fn answer_all(&self) {
        let refused = || Progress::Ended(Outcome::Exception(interrupted("kill")));
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            let Control { services, entries, .. } = &mut *control;
            let askers = services.iter_mut().filter_map(|queue| queue.asker.take());
            let replies = askers.filter_map(|asker| asker.take());
            after.replies.extend(replies.map(|reply| (reply, refused())));
            let with_task =
                |entry: &&mut Entry| entry.service.is_some() && matches!(entry.stage, Stage::Sent);
            for entry in entries.iter_mut().filter(with_task) {
                after.ended(entry, Outcome::Exception(interrupted("kill")));
                entry.stage = Stage::Cancelled;
            }
        }
        self.finish_off(after);
    }

    fn what_hangs(&self) -> ShutdownError {
        let activities = self.activities().into_iter().map(|activity| {
            let name = activity.service.unwrap_or(activity.task);
            format!("{name} ({})", activity.id)
        });
        let mut codels = self.running_codels();
        if codels.is_empty() {
            // A codel of another instance may have the thread that this one shares.
            codels.extend(self.single.as_ref().and_then(|executor| executor.running()));
        }
        ShutdownError { instance: self.name.clone(), codels, activities: activities.collect() }
    }

    fn join(&self) {
        let workers = std::mem::take(&mut self.lock().workers);
        let threads = std::mem::take(&mut *lock(&self.threads));
        for thread in threads.into_iter().chain(workers) {
            // One of them may be the calling thread, if a reply calls this.
            if thread.thread().id() != std::thread::current().id() {
                let _ = thread.join();
            }
        }
        if let (Some(executor), Some(call)) = (&self.single, &self.shared.call)
            && !executor.is_here()
        {
            call.wait_until_gone();
        }
    }
}
