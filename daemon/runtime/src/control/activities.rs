//! Activities from acceptance to start, and requests to stop (genom3.md 7.5, 7.6).

use std::sync::Arc;

use genom_description::model::ServiceIx;

use super::{Afterwards, Control, Entry, Phase, Stage, interrupted};
use crate::api::{Outcome, Progress, Reply};
use crate::body::Frame;
use crate::engine::{Engine, NoSuchActivity};
use crate::rules::Happening;
use crate::task::run::{Marker, Run, Status};
use crate::watcher::Change;

impl Engine {
    /// Creates a run of this machine. All its memory is allocated here, none by the task.
    pub(crate) fn new_run(&self, id: u32, machine: usize, mut frame: Box<dyn Frame>) -> Box<Run> {
        frame.number(id);
        let compiled = &self.shared.plan.machines()[machine];
        Box::new(Run {
            id,
            machine,
            frame,
            marker: Arc::new(Marker::new(compiled.start)),
            tokens: Vec::with_capacity(compiled.codels.len() + 1),
            at_stop: false,
            outcome: None,
        })
    }

    /// genom3.md 7.3.11: accepts the activity; it starts when nothing that it interrupts runs.
    pub(crate) fn accept(&self, service: ServiceIx, frame: Box<dyn Frame>, mut reply: Reply) {
        let compiled = &self.shared.plan.services()[service];
        let (Some(machine), Some(task)) = (compiled.machine, compiled.task) else { return };
        let mut after = Afterwards::default();
        let run = {
            let mut control = self.lock();
            let run = self.new_run(control.new_id(), machine, frame);
            // During a shutdown nothing starts any more, but the client is answered as usual.
            let stopping = control.phase != Phase::Running;
            control.entries.push(Entry {
                id: run.id,
                service: Some(service),
                task,
                marker: Arc::clone(&run.marker),
                stage: Stage::Accepting,
                by: stopping.then(|| "kill".to_owned()),
                reply: None,
                accepted: self.shared.clock.now(),
                asked: None,
                late: 0,
            });
            run
        };
        let id = run.id;
        self.happens(Happening::Accept(service), id);
        if let Some(watcher) = &self.watcher {
            watcher.changed(&Change::Accepted { activity: id, service });
        }
        reply(Progress::Accepted { activity: id });
        {
            let mut control = self.lock();
            control.dirty = true;
            let Some(at) = control.entries.iter().position(|entry| entry.id == id) else { return };
            let entry = &mut control.entries[at];
            entry.reply = Some(reply);
            entry.stage = Stage::Pending(run);
            if let Some(by) = entry.by.take() {
                // It was asked to stop while the client was informed of its id.
                self.stop(&mut control, at, &by, &mut after);
            }
            self.examine(&mut control, &mut after);
        }
        // A step of the virtual clock waits for this.
        self.quiet.notify_all();
        self.shared.wake_control();
        self.finish_off(after);
    }

    /// Asks an activity to stop.
    pub(crate) fn abort(&self, id: u32, by: &str) -> Result<(), NoSuchActivity> {
        let mut after = Afterwards::default();
        {
            let mut control = self.lock();
            let is = |entry: &Entry| entry.id == id && entry.service.is_some();
            let at = control.entries.iter().position(is).ok_or(NoSuchActivity { activity: id })?;
            self.stop(&mut control, at, by, &mut after);
            self.examine(&mut control, &mut after);
        }
        self.finish_off(after);
        Ok(())
    }

    /// Asks all activities of services to stop. Returns ids and services of those that have not
    /// ended, including those asked earlier.
    pub(crate) fn abort_all(&self, by: &str) -> Vec<(u32, ServiceIx)> {
        let mut after = Afterwards::default();
        let mut told = Vec::new();
        {
            let mut control = self.lock();
            for at in 0..control.entries.len() {
                let entry = &control.entries[at];
                let answered = matches!(entry.stage, Stage::Cancelled | Stage::Gone);
                let Some(service) = entry.service.filter(|_| !answered) else { continue };
                told.push((entry.id, service));
                self.stop(&mut control, at, by, &mut after);
            }
            self.examine(&mut control, &mut after);
        }
        self.finish_off(after);
        told
    }

    /// genom3.md 7.6: asks the activities that `service` interrupts to stop, except activity `but`.
    pub(crate) fn interrupt(
        &self,
        control: &mut Control,
        service: ServiceIx,
        but: Option<u32>,
        after: &mut Afterwards,
    ) {
        let interrupts = &self.shared.plan.services()[service].interrupts;
        let by = &self.shared.plan.component().services[service].name;
        for at in 0..control.entries.len() {
            let entry = &control.entries[at];
            if Some(entry.id) != but && entry.service.is_some_and(|other| interrupts[other]) {
                self.stop(control, at, by, after);
            }
        }
    }

    /// genom3.md 7.5: handles a stop request. A second one has no effect.
    pub(crate) fn stop(&self, control: &mut Control, at: usize, by: &str, after: &mut Afterwards) {
        let entry = &mut control.entries[at];
        if entry.by.is_some() {
            return;
        }
        match &entry.stage {
            Stage::Accepting => entry.by = Some(by.to_owned()),
            Stage::Pending(_) => {
                entry.by = Some(by.to_owned());
                after.ended(entry, Outcome::Exception(interrupted(by)));
                let (task, service) = (entry.task, entry.service);
                let stage = std::mem::replace(&mut entry.stage, Stage::Gone);
                if let (Stage::Pending(run), Some(service)) = (stage, service) {
                    self.give_frame(service, run.frame);
                }
                control.links[task].used -= 1;
                control.dirty = true;
            }
            Stage::Sent if entry.marker.leave_init(Status::Cancelled) => {
                entry.by = Some(by.to_owned());
                after.ended(entry, Outcome::Exception(interrupted(by)));
                entry.stage = Stage::Cancelled;
                self.shared.tasks[entry.task].wake();
                control.dirty = true;
            }
            Stage::Sent if entry.marker.status() == Status::Run => {
                entry.by = Some(by.to_owned());
                entry.asked = Some(self.shared.clock.now());
                entry.marker.request_stop();
                self.shared.tasks[entry.task].wake();
                if let Some(service) = entry.service {
                    self.happens(Happening::Stop(service), entry.id);
                }
            }
            Stage::Sent | Stage::Cancelled | Stage::Gone => {}
        }
    }

    /// genom3.md 7.6: pending activities stop those they interrupt, the newest first, so that of
    /// two that interrupt each other the newest wins. Then those start that have nothing left to
    /// wait for.
    pub(crate) fn examine(&self, control: &mut Control, after: &mut Afterwards) {
        for at in (0..control.entries.len()).rev() {
            let Entry { id, service, stage, .. } = &control.entries[at];
            if let (Stage::Pending(_), Some(service), id) = (stage, *service, *id) {
                self.interrupt(control, service, Some(id), after);
            }
        }
        control.entries.retain(|entry| !matches!(entry.stage, Stage::Gone));
        for at in 0..control.entries.len() {
            let entry = &control.entries[at];
            let (Stage::Pending(_), Some(service)) = (&entry.stage, entry.service) else {
                continue;
            };
            let interrupts = &self.shared.plan.services()[service].interrupts;
            let blocks = |other: &Entry| {
                other.id != entry.id
                    && other.service.is_some_and(|service| interrupts[service])
                    && other.is_running()
            };
            if control.entries.iter().any(blocks) {
                continue;
            }
            let entry = &mut control.entries[at];
            let task = entry.task;
            let stage = std::mem::replace(&mut entry.stage, Stage::Sent);
            if let Stage::Pending(run) = stage {
                control.send(task, run);
                self.shared.tasks[task].wake();
            }
        }
    }
}
