//! Results of tasks on their way to clients (genom3.md 7.5, "Ends").

use genom_description::model::TaskIx;
use serde_json::{Value, json};

use super::{Afterwards, Control, Stage, genom, interrupted, take_attention};
use crate::api::{Exception, Outcome};
use crate::engine::Engine;
use crate::shared::Notice;
use crate::task::run::{Bad, Run, RunOutcome};
use crate::watcher::Change;

impl Engine {
    /// Takes what tasks handed back, answers clients, and starts what waited for it. Returns
    /// whether there was anything.
    pub(crate) fn attend(&self) -> bool {
        let asked = take_attention(&self.shared);
        let mut after = Afterwards::default();
        let write_state = {
            let mut control = self.lock();
            for task in control.links.places() {
                let link = &mut control.links[task];
                // Ends first: what led to them is then in the other ring already.
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
                for run in ended {
                    self.finish(&mut control, task, run, &mut after);
                }
            }
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

    /// Tells clients and watchers, without any lock.
    pub(crate) fn finish_off(&self, after: Afterwards) {
        if let Some(watcher) = &self.watcher {
            after.changes.iter().for_each(|change| watcher.changed(change));
        }
        for (mut reply, progress) in after.replies {
            reply(progress);
        }
        if after.kill {
            self.wiring.kill();
        }
    }

    fn finish(
        &self,
        control: &mut Control,
        task: TaskIx,
        mut run: Box<Run>,
        after: &mut Afterwards,
    ) {
        control.dirty = true;
        let Some(at) = control.entries.iter().position(|entry| entry.id == run.id) else { return };
        let mut entry = control.entries.remove(at);
        let outcome = self.outcome(&run, entry.by.as_deref());
        let Some(service) = entry.service else {
            // 7.5: a permanent activity that fails takes the component with it.
            if let Outcome::Exception(exception) = outcome {
                let name = &self.shared.plan.component().tasks[task].name;
                tracing::error!(instance = self.name, task = name, "task failed: {exception}");
                after.changes.push(Change::Failed { task, exception: exception.name.clone() });
                after.kill = control.phase == super::Phase::Running;
                control.failure.get_or_insert((task, exception));
            }
            return;
        };
        control.links[task].used -= 1;
        run.tokens.clear();
        if !matches!(entry.stage, Stage::Cancelled) {
            // 7.5: only success counts as run.
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
                // States come first in the table of events, in order.
                let from = plan.event_name(crate::body::EventId(from));
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
