//! Goes on where another instance was: after the start codels, before anything else runs.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_description::model::{Ix as _, Owner, PortDirection, ServiceIx};
use genom_types::Record;
use serde_json::Value;

use crate::api::{ActivityPhase, Outcome, Progress, Reply};
use crate::control::{Entry, Stage, genom, interrupted};
use crate::engine::Engine;
use crate::frozen::{FrozenActivity, FrozenToken, Resume, Resumed, Waiting};
use crate::lock::lock;
use crate::plan::Machine;
use crate::rules::Happening;
use crate::task::run::{Mode, RunOutcome, Status, Token};
use crate::watcher::Change;

/// An activity is in a state in which no codel of it runs.
#[derive(Debug, thiserror::Error)]
#[error("no codel of it runs in state {state}")]
struct NoCodel {
    state: String,
}

impl Engine {
    /// Called once, when each task has made its first pass and is held.
    pub(crate) fn resume(&self, resume: Resume) {
        let body = &self.shared.body;
        let model = self.shared.plan.component();
        {
            let _gates: Vec<_> = self.gates.iter().map(|gate| gate.lock()).collect();
            if let Some(change) = resume.ids {
                self.change_ids(change);
            }
            let is_out = |port| {
                let port = model.ports.get(port);
                port.is_some_and(|port| port.direction == PortDirection::Out)
            };
            let (out, inward): (Vec<_>, Vec<_>) =
                resume.ports.into_iter().partition(|port| is_out(port.port));
            for port in out {
                body.restore_port(port.port, port.element.as_deref(), &port.value);
            }
            if resume.hold {
                *lock(&self.in_ports) = inward;
            }
            let mut control = self.lock();
            control.dirty = true;
            for service in resume.executed {
                if let Some(queue) = control.services.get_mut(service) {
                    queue.ran = true;
                    self.shared.rules.has_run(&self.shared.plan, service);
                    // What formulas and orders ask for was done in the instance before.
                    self.happened(Happening::Start(service));
                    self.happened(Happening::End(service));
                }
            }
        }
        self.resume_permanent(&resume.activities);
        for Resumed { activity, reply, goes_on } in resume.activities {
            if let (Owner::Service(service), Some(reply)) = (activity.owner, reply) {
                self.resume_activity(service, activity, reply, !goes_on);
            }
        }
        self.lock().entries.sort_by_key(|entry| entry.id);
        if !resume.hold {
            self.go_on();
        }
    }

    /// Changes the IDS, while no codel runs.
    pub(crate) fn change_ids(&self, change: impl FnOnce(&mut Record)) {
        let body = &self.shared.body;
        if let Some(mut ids) = body.ids() {
            change(&mut ids);
            body.set_ids(&ids);
        }
    }

    /// Lets tasks go on that are held. Never waits for one whose first codel hangs: before all have
    /// made their first pass, no in port waits for its value.
    pub(crate) fn go_on(&self) {
        let ports = std::mem::take(&mut *lock(&self.in_ports));
        if !ports.is_empty() {
            let _gates: Vec<_> = self.gates.iter().map(|gate| gate.lock()).collect();
            for port in ports {
                let element = port.element.as_deref();
                self.shared.body.restore_port(port.port, element, &port.value);
            }
        }
        if self.shared.held.swap(false, Ordering::AcqRel) {
            self.shared.rules.await_beats(self.shared.clock.now());
            self.shared.wake_tasks();
            self.shared.wake_control();
        }
    }

    /// Moves permanent activities from where their start codels led them to where they were.
    fn resume_permanent(&self, all: &[Resumed]) {
        for task in self.shared.tasks.places() {
            let name = &self.shared.plan.component().tasks[task].name;
            let machine = &self.shared.plan.machines()[task.index()];
            let is_of_task = |one: &&Resumed| one.activity.owner == Owner::Task(task);
            let Some(wanted) = all.iter().find(is_of_task).map(|one| &one.activity) else {
                continue;
            };
            let mut inside = self.gates[task].lock();
            let Some(run) = inside.core.run_of(task.index()) else {
                if !wanted.tokens.is_empty() {
                    self.not_resumed(format!("task {name}: its first codel ended it"));
                }
                continue;
            };
            if run.outcome.is_some() {
                continue;
            }
            match self.tokens(&wanted.tokens, machine) {
                // It had ended: its `stop` codel runs at the shutdown, as usual.
                Ok(tokens) if tokens.is_empty() => {
                    run.tokens.clear();
                    run.outcome = Some(RunOutcome::Success);
                }
                Ok(tokens) => {
                    run.tokens.clear();
                    run.tokens.extend(tokens);
                    run.tokens.last().map(|token| run.marker.show(*token));
                }
                Err(why) => {
                    self.not_resumed(format!(
                        "task {name}: {why}; it goes on after its start codel"
                    ));
                }
            }
        }
    }

    fn resume_activity(
        &self,
        service: ServiceIx,
        activity: FrozenActivity,
        mut reply: Reply,
        tell: bool,
    ) {
        let compiled = &self.shared.plan.services()[service];
        let name = &self.shared.plan.component().services[service].name;
        let refuse = |mut reply: Reply, why: String, exception| {
            self.not_resumed(format!("activity {name} ({}): {why}", activity.id));
            reply(Progress::Ended(Outcome::Exception(exception)));
        };
        let (Some(machine), Some(task)) = (compiled.machine, compiled.task) else {
            return refuse(reply, "it is no activity".to_owned(), interrupted("resume"));
        };
        let tokens = match self.tokens(&activity.tokens, &self.shared.plan.machines()[machine]) {
            Ok(tokens) => tokens,
            Err(why) => return refuse(reply, why.to_string(), interrupted("resume")),
        };
        let id = {
            let mut control = self.lock();
            if control.links[task].used >= self.activity_limit {
                drop(control);
                let why = format!("there are {} activities in its task", self.activity_limit);
                return refuse(reply, why, genom("too_many_activities", Value::Null));
            }
            control.links[task].used += 1;
            let taken = control.entries.iter().any(|entry| entry.id == activity.id);
            if taken || activity.id == 0 {
                control.new_id()
            } else {
                control.next_id = control.next_id.max(activity.id.checked_add(1).unwrap_or(1));
                activity.id
            }
        };
        let mut frame = self.take_frame(service);
        if let Some(memory) = &activity.memory {
            frame.restore(memory);
        }
        let mut run = self.new_run(id, machine, frame);
        run.tokens.extend(tokens);
        let marker = Arc::clone(&run.marker);
        let watcher = self.watcher.as_ref().filter(|_| tell);
        if let Some(watcher) = watcher {
            watcher.changed(&Change::Accepted { activity: id, service });
        }
        if tell {
            reply(Progress::Accepted { activity: id });
        }
        if let Some(token) = run.tokens.last() {
            marker.show(*token);
            if let Some(watcher) = watcher {
                let (state, paused) = marker.place();
                watcher.changed(&Change::Moved { activity: id, state, paused });
            }
        }
        marker.set(match activity.phase {
            ActivityPhase::Init => Status::Init,
            ActivityPhase::Run => Status::Run,
            ActivityPhase::Stop | ActivityPhase::Ether => Status::Stop,
        });
        if activity.phase == ActivityPhase::Run && activity.stopped_by.is_some() {
            marker.request_stop();
        }
        let stage = if activity.pending {
            Stage::Pending(run)
        } else {
            self.gates[task].lock().core.admit(run);
            Stage::Sent
        };
        let by = activity.stopped_by;
        if activity.phase != ActivityPhase::Init {
            self.shared.rules.begins(machine);
            self.happened(Happening::Start(service));
        }
        self.lock().entries.push(Entry {
            id,
            service: Some(service),
            task,
            marker,
            stage,
            by,
            asked: None,
            reply: Some(reply),
            accepted: self.shared.clock.now(),
            late: 0,
        });
    }

    /// The marking, if all its states have codels. Each state counts once.
    fn tokens(&self, wanted: &[FrozenToken], machine: &Machine) -> Result<Vec<Token>, NoCodel> {
        let mut tokens: Vec<Token> = Vec::with_capacity(wanted.len());
        for one in wanted {
            let mode = match one.waits {
                Waiting::Ready => Mode::Ready,
                Waiting::Paused => Mode::Paused,
                Waiting::Asleep => Mode::Asleep,
            };
            // A place that sleeps may have no codel.
            if machine.codel(one.state).is_none() && mode != Mode::Asleep {
                let name = self.shared.plan.component().states.get(one.state);
                let name = name.map_or("", String::as_str);
                return Err(NoCodel { state: name.to_owned() });
            }
            if !tokens.iter().any(|token| token.state == one.state) {
                tokens.push(Token { state: one.state, mode });
            }
        }
        Ok(tokens)
    }

    fn not_resumed(&self, what: String) {
        tracing::warn!(instance = self.name, "not resumed: {what}");
        lock(&self.unresumed).push(what);
    }
}
