//! Collects results of tasks and answers clients (genom3.md 7.5, "Ends").

use genom_description::model::TaskIx;
use serde_json::{Value, json};

use super::{Afterwards, Control, Stage, genom, interrupted, take_attention};
use crate::api::{Exception, Outcome};
use crate::engine::Engine;
use crate::rules::Seen;
use crate::shared::Notice;
use crate::task::run::{Bad, Run, RunOutcome};
use crate::watcher::Change;

impl Engine {
    /// Collects the runs that ended, answers clients, and starts the activities that waited.
    /// Returns whether control had been asked to.
    pub(crate) fn attend(&self) -> bool {
        let asked = take_attention(&self.shared);
        let mut after = Afterwards::default();
        let now = self.shared.clock.now();
        let write_state = {
            let mut control = self.lock();
            for task in control.links.places() {
                let link = &mut control.links[task];
                // Ended runs first: the notices that preceded an end are then already in the other
                // ring.
                let ended: Vec<Box<Run>> = std::iter::from_fn(|| link.from.pop().ok()).collect();
                if let Some(notices) = &mut link.notices {
                    let notices = std::iter::from_fn(|| notices.pop().ok());
                    after.changes.extend(notices.map(|notice| match notice {
                        Notice::Moved { activity, state, paused } => {
                            Change::Moved { activity, state, paused }
                        }
                        Notice::Overrun { task, ticks } => Change::Overrun { task, ticks },
                    }));
                }
                let broken = link.broken.as_mut().into_iter();
                let broken: Vec<Seen> =
                    broken.flat_map(|ring| std::iter::from_fn(|| ring.pop().ok())).collect();
                for seen in broken {
                    self.violated(&mut control, seen, &mut after);
                }
                for run in ended {
                    self.finish(&mut control, task, run, now, &mut after);
                }
            }
            for seen in self.shared.rules.take_aside() {
                self.violated(&mut control, seen, &mut after);
            }
            self.look_at_rules(&mut control, now, &mut after);
            self.examine(&mut control, &mut after);
            std::mem::take(&mut control.dirty)
        };
        self.quiet.notify_all();
        if write_state {
            self.write_state();
        }
        self.finish_off(after);
        asked
    }

    /// Informs clients and watchers, without holding any lock.
    pub(crate) fn finish_off(&self, after: Afterwards) {
        if let Some(watcher) = &self.watcher {
            after.changes.iter().for_each(|change| watcher.changed(change));
        }
        for (mut reply, progress) in after.replies {
            reply(progress);
        }
        if after.kill {
            self.supervision.kill();
        }
    }

    fn finish(
        &self,
        control: &mut Control,
        task: TaskIx,
        mut run: Box<Run>,
        now: u64,
        after: &mut Afterwards,
    ) {
        control.dirty = true;
        let Some(at) = control.entries.iter().position(|entry| entry.id == run.id) else { return };
        // One that ends when its time is just over is in time.
        self.look_at_activity(control, at, now.saturating_sub(1), after);
        let mut entry = control.entries.remove(at);
        let outcome = self.outcome(&run, entry.by.as_deref());
        let Some(service) = entry.service else {
            // genom3.md 7.5: when a permanent activity fails, the component is shut down.
            if let Outcome::Exception(exception) = outcome {
                let name = &self.shared.plan.component().tasks[task].name;
                tracing::error!(instance = self.name, task = name, "task failed: {exception}");
                after.changes.push(Change::Failed { task, exception: exception.name.clone() });
                after.kill = control.phase == super::Phase::Running;
                control.failure.get_or_insert((task, exception));
            }
            // genom3.md 7.5: `stop` always runs, also if the codel during which it was asked for
            // ended the activity.
            if entry.marker.stop_requested() && !run.at_stop && self.has_stop(task) {
                self.send_permanent_with(control, task, run.frame, true);
                self.shared.tasks[task].hurry();
            }
            return;
        };
        control.links[task].used -= 1;
        run.tokens.clear();
        if !matches!(entry.stage, Stage::Cancelled) {
            // genom3.md 7.5: a service counts as run only after success.
            control.services[service].ran |= matches!(outcome, Outcome::Success(_));
            after.ended(&mut entry, outcome);
        }
        self.give_frame(service, run.frame);
    }

    fn outcome(&self, run: &Run, by: Option<&str>) -> Outcome {
        let plan = &self.shared.plan;
        let detail = || run.frame.detail().unwrap_or(Value::Null);
        let exception = match run.outcome {
            Some(RunOutcome::Success) | None => {
                return Outcome::Success(run.frame.output().clone());
            }
            Some(RunOutcome::Thrown(event)) => {
                Exception { name: plan.event_name(event).to_owned(), detail: detail() }
            }
            Some(RunOutcome::Failed) => genom("unkex", detail()),
            Some(RunOutcome::Interrupted | RunOutcome::Cancelled) => {
                interrupted(by.unwrap_or("client"))
            }
            Some(RunOutcome::Bad { from, to }) => {
                let from = plan.state_name(from);
                let to = match to {
                    Bad::Ok => "genom_ok".to_owned(),
                    Bad::Event(event) => plan.event_name(event).to_owned(),
                    Bad::Unknown => run.frame.returned(),
                };
                tracing::warn!(instance = self.name, from, to, "bad transition");
                genom("bad_transition", json!({ "from": from, "to": to }))
            }
        };
        Outcome::Exception(exception)
    }
}
