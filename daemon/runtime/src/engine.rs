//! State that the threads of an instance share.

use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use genom_description::model::{Indexed, Owner, ServiceIx, TaskIx};

use crate::api::{ActivityPhase, Supervision};
use crate::body::Frame;
use crate::control::window::Window;
use crate::control::{Control, Stage};
use crate::executor::Executor;
use crate::frozen::FrozenPort;
use crate::lock::{Guard, Signal, lock};
use crate::shared::Shared;
use crate::task::driven::DrivenTask;
use crate::task::gate::Gate;
use crate::task::run::Status;
use crate::watcher::Watcher;

/// Frames of a service kept for its next requests.
const SPARE_FRAMES: usize = 2;

/// State of a running instance.
pub(crate) struct Engine {
    pub(crate) name: String,
    /// Ticks are counted from this date.
    pub(crate) epoch: u64,
    pub(crate) shared: Arc<Shared>,
    pub(crate) supervision: Arc<dyn Supervision>,
    pub(crate) watcher: Option<Arc<dyn Watcher>>,
    pub(crate) activity_limit: usize,
    /// A codel without period that runs longer counts as stuck.
    pub(crate) stuck_after: Duration,
    /// Build date of the component.
    pub(crate) date: Mutex<String>,
    control: Mutex<Control>,
    /// Notified when a request is ready for a worker, or when the workers have to end.
    pub(crate) work: Condvar,
    /// Notified when a request, an activity or a thread ended.
    pub(crate) quiet: Signal,
    /// Frames for reuse, by service.
    spare: Mutex<Indexed<ServiceIx, Vec<Box<dyn Frame>>>>,
    /// Tasks of an instance on a virtual clock.
    pub(crate) driven: Option<Mutex<Vec<DrivenTask>>>,
    /// The thread that it shares with other instances, if it does.
    pub(crate) single: Option<Arc<Executor>>,
    /// Date of the last value of the state port.
    pub(crate) state_written: AtomicU64,
    /// Averages over about the last ten seconds, by task. Locked while the state port is written.
    pub(crate) recent: Mutex<Vec<Window>>,
    /// Held by the thread that excludes everything, so that only one does.
    pub(crate) everything: Mutex<()>,
    /// What each task uses during its passes.
    pub(crate) gates: Indexed<TaskIx, Arc<Gate>>,
    /// In ports that get their last values when the tasks go on after they were held.
    pub(crate) in_ports: Mutex<Vec<FrozenPort>>,
    /// What could not be resumed, and why.
    pub(crate) unresumed: Mutex<Vec<String>>,
    /// Held while a shutdown takes a step.
    pub(crate) advancing: Mutex<()>,
    pub(crate) threads: Mutex<Vec<JoinHandle<()>>>,
    /// Rounds of the control thread so far; [`OVER`] once it has ended.
    pub(crate) rounds: AtomicU64,
}

/// In place of a number of rounds: there is no control thread any more.
pub(crate) const OVER: u64 = u64::MAX;

/// No activity has this id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no activity {activity}: it has ended, or never was")]
pub struct NoSuchActivity {
    /// The requested id.
    pub activity: u32,
}

/// An activity that has been accepted and not reported as ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActivityStatus {
    /// Number that `abort_activity` takes.
    pub id: u32,
    /// Its service; `None` for the permanent activity of a task.
    pub service: Option<String>,
    /// Name of the task that runs it.
    pub task: String,
    /// Phase of its life.
    pub phase: ActivityPhase,
    /// Its state (the first one, if several are active).
    pub state: String,
    /// Whether it waits for the next tick or event.
    pub paused: bool,
    /// Name of who asked it to stop, if anybody did.
    pub stopped_by: Option<String>,
}

impl Engine {
    pub(crate) fn new(
        options: crate::Options,
        shared: Arc<Shared>,
        control: Control,
        gates: Indexed<TaskIx, Arc<Gate>>,
        driven: Option<Vec<DrivenTask>>,
        single: Option<Arc<Executor>>,
    ) -> Self {
        let spare = shared.plan.services().map(|_, _| Vec::new());
        let tasks = shared.tasks.iter().map(|_| Window::default()).collect();
        Self {
            name: options.name,
            epoch: options.epoch.unwrap_or_default(),
            shared,
            supervision: options.supervision,
            watcher: options.watcher,
            activity_limit: options.activity_limit,
            stuck_after: options.stuck_after,
            date: Mutex::new(options.date),
            control: Mutex::new(control),
            work: Condvar::new(),
            quiet: Signal::default(),
            spare: Mutex::new(spare),
            driven: driven.map(Mutex::new),
            single,
            state_written: AtomicU64::default(),
            recent: Mutex::new(tasks),
            everything: Mutex::new(()),
            gates,
            in_ports: Mutex::default(),
            unresumed: Mutex::default(),
            advancing: Mutex::new(()),
            threads: Mutex::new(Vec::new()),
            rounds: AtomicU64::new(0),
        }
    }

    pub(crate) fn lock(&self) -> Guard<'_, Control> {
        lock(&self.control)
    }

    pub(crate) fn take_frame(&self, service: ServiceIx) -> Box<dyn Frame> {
        let spare = lock(&self.spare)[service].pop();
        spare.unwrap_or_else(|| self.shared.body.frame(Owner::Service(service)))
    }

    pub(crate) fn give_frame(&self, service: ServiceIx, frame: Box<dyn Frame>) {
        let mut spare = lock(&self.spare);
        if spare[service].len() < SPARE_FRAMES {
            spare[service].push(frame);
        }
    }

    pub(crate) fn activities(&self) -> Vec<ActivityStatus> {
        let model = self.shared.plan.component();
        let control = self.lock();
        let status = |entry: &crate::control::Entry| {
            let (state, paused) = entry.marker.place();
            let phase = match (&entry.stage, entry.marker.status()) {
                (Stage::Accepting | Stage::Pending(_), _) => ActivityPhase::Init,
                (Stage::Cancelled | Stage::Gone, _) => return None,
                (Stage::Sent, Status::Init | Status::Cancelled) => ActivityPhase::Init,
                (Stage::Sent, Status::Run) => ActivityPhase::Run,
                (Stage::Sent, Status::Stop) => ActivityPhase::Stop,
                (Stage::Sent, Status::Ether) => ActivityPhase::Ether,
            };
            Some(ActivityStatus {
                id: entry.id,
                service: entry.service.map(|service| model.services[service].name.clone()),
                task: model.tasks[entry.task].name.clone(),
                phase,
                state: model.states.get(state).cloned().unwrap_or_default(),
                paused,
                stopped_by: entry.by.clone(),
            })
        };
        control.entries.iter().filter_map(status).collect()
    }
}
