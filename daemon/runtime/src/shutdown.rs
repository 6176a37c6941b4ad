//! Shutdown (genom3.md 7.7).

use std::sync::PoisonError;
use std::time::{Duration, Instant};

use crate::api::{Outcome, Progress};
use crate::control::{Afterwards, Control, Phase, interrupted};
use crate::engine::{Engine, lock};
use crate::plan::owner_name;

/// Why an instance did not shut down in time. It serves nothing any more; threads that hang are
/// left behind with the memory they use, and other instances go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{instance} does not shut down: {}", list(.codels, .activities))]
pub struct ShutdownError {
    /// The instance.
    pub instance: String,
    /// Codels that have not returned: `owner: codel`.
    pub codels: Vec<String>,
    /// Activities that have not ended.
    pub activities: Vec<String>,
}

fn list(codels: &[String], activities: &[String]) -> String {
    if codels.is_empty() {
        format!("activities {} do not end after a stop request", activities.join(", "))
    } else {
        format!("codels have not returned ({})", codels.join(", "))
    }
}

impl Engine {
    /// Stops activities, then permanent ones, then threads.
    pub(crate) fn shutdown(&self, timeout: Duration) -> Result<(), ShutdownError> {
        let deadline = Instant::now() + timeout;
        if !self.stop_activities() {
            return Ok(());
        }
        let ended = self.wait(deadline, |control| {
            control.serving == 0 && control.entries.iter().all(|entry| entry.service.is_none())
        });
        // 7.7.2: tasks in reverse order.
        let tasks = self.shared.tasks.len();
        let ended = (0..tasks).rev().fold(ended, |ended, task| {
            // A task that hangs cannot run its `stop` codel; the others can.
            self.stop_permanent(task);
            let gone = |control: &Control| control.entries.iter().all(|e| e.task != task);
            self.wait(deadline, gone) && ended
        });
        let error = (!ended).then(|| self.what_hangs());
        self.shared.tasks.iter().for_each(crate::shared::TaskShared::quit);
        self.lock().phase = Phase::Stopped;
        self.work.notify_all();
        self.shared.wake_control();
        let threads_ended = self.driven.is_some() || self.wait(deadline, |c| c.alive == 0);
        match error {
            Some(error) => Err(error),
            None if !threads_ended => Err(self.what_hangs()),
            None => {
                self.join();
                Ok(())
            }
        }
    }

    /// 7.7.1; `false` when somebody else shut it down before.
    fn stop_activities(&self) -> bool {
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            if matches!(control.phase, Phase::Stopping | Phase::Stopped) {
                return false;
            }
            control.phase = Phase::Stopping;
            control.ready.clear();
            let waiting = control.services.iter_mut().flat_map(|queue| queue.waiting.drain(..));
            let refused = || Progress::Done(Outcome::Exception(interrupted("kill")));
            after.replies.extend(waiting.map(|request| (request.reply, refused())));
            for at in 0..control.entries.len() {
                if control.entries[at].service.is_some() {
                    self.stop(&mut control, at, "kill", &mut after);
                }
            }
            self.examine(&mut control, &mut after);
        }
        self.finish_off(after);
        self.shared.tasks.iter().for_each(crate::shared::TaskShared::hurry);
        true
    }

    /// Asks a permanent activity to stop; one that ended runs its `stop` codel all the same.
    fn stop_permanent(&self, task: usize) {
        let marker = {
            let control = self.lock();
            let mut entries = control.entries.iter();
            let permanent =
                |entry: &&crate::control::Entry| entry.task == task && entry.service.is_none();
            entries.find(permanent).map(|entry| std::sync::Arc::clone(&entry.marker))
        };
        let machine = &self.shared.plan.machines()[task];
        match marker {
            Some(marker) => marker.request_stop(),
            // A task whose thread never was has nothing to undo.
            None if machine.codel(machine.stop).is_none() || !self.has_thread(task) => return,
            None => self.send_permanent(task, true),
        }
        self.shared.tasks[task].hurry();
    }

    fn has_thread(&self, task: usize) -> bool {
        self.shared.tasks[task].is_started()
    }

    /// Waits for `done`, which others bring about; on a virtual clock it is brought about here.
    fn wait(&self, deadline: Instant, done: impl Fn(&Control) -> bool) -> bool {
        if self.driven.is_some() {
            return self.drive_until(|engine| done(&engine.lock()));
        }
        // Before the control thread runs, or after, nobody else collects results.
        let mut control = self.lock();
        while !done(&control) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            if self.shared.control.get().is_none() {
                drop(control);
                self.attend();
                control = self.lock();
                if done(&control) {
                    return true;
                }
            }
            let slice = left.min(Duration::from_millis(10));
            let waited = self.quiet.wait_timeout(control, slice);
            control = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    fn what_hangs(&self) -> ShutdownError {
        let model = self.shared.plan.component();
        let name = |codel: usize| {
            let codel = &model.codels[codel];
            format!("{}: {}", owner_name(model, codel.owner), codel.name)
        };
        let contexts = 0..=self.shared.outside_context();
        let codels = contexts.filter_map(|context| self.shared.current(context)).map(name);
        let activities = self.activities().into_iter().map(|activity| {
            let name = activity.service.unwrap_or(activity.task);
            format!("{name} ({})", activity.id)
        });
        ShutdownError {
            instance: self.name.clone(),
            codels: codels.collect(),
            activities: activities.collect(),
        }
    }

    fn join(&self) {
        let workers = std::mem::take(&mut self.lock().workers);
        let threads = std::mem::take(&mut *lock(&self.threads));
        for thread in threads.into_iter().chain(workers) {
            // One of them may be the caller, through a reply.
            if thread.thread().id() != std::thread::current().id() {
                let _ = thread.join();
            }
        }
    }
}
