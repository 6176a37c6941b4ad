//! Control: what requests, activities and shutdown share, under one lock that no task takes.

pub(crate) mod activities;
pub(crate) mod builtin;
pub(crate) mod collect;
pub(crate) mod requests;
pub(crate) mod state_port;
pub(crate) mod window;
pub(crate) mod workers;

use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use genom_description::model::{Indexed, ServiceIx, TaskIx};
use rtrb::{Consumer, Producer};
use serde_json::{Value, json};

use crate::api::{Exception, Inputs, OnShutdown, Outcome, Progress, Reply};
use crate::lock::lock;
use crate::plan::Plan;
use crate::shared::Notice;
use crate::task::run::{Marker, Run};
use crate::ticket::Ticket;
use crate::watcher::Change;

/// A request on its way.
pub(crate) struct Request {
    pub(crate) inputs: Inputs,
    pub(crate) reply: Reply,
    pub(crate) ticket: Ticket,
}

/// The reply of a request that is being served: whoever takes it answers, only once.
#[derive(Clone)]
pub(crate) struct Asker(Arc<Mutex<Option<Reply>>>);

impl Asker {
    pub(crate) fn new(reply: Reply) -> Self {
        Self(Arc::new(Mutex::new(Some(reply))))
    }

    /// The reply; `None` when it was taken before.
    pub(crate) fn take(&self) -> Option<Reply> {
        lock(&self.0).take()
    }
}

/// Requests of one service: one at a time, in order of arrival.
#[derive(Default)]
pub(crate) struct ServiceQueue {
    pub(crate) waiting: VecDeque<Request>,
    /// A worker is at one of its requests.
    pub(crate) busy: bool,
    /// Who waits for that one.
    pub(crate) asker: Option<Asker>,
    /// It was executed successfully at least once (genom3.md 7.6).
    pub(crate) ran: bool,
}

/// Where an activity is, as control sees it.
pub(crate) enum Stage {
    /// The client is being told its id.
    Accepting,
    /// Waits until what it interrupts has ended.
    Pending(Box<Run>),
    /// With its task.
    Sent,
    /// Answered already; its task will give it back.
    Cancelled,
    /// Answered, and nothing is left of it.
    Gone,
}

/// An activity of a service, or a permanent one.
pub(crate) struct Entry {
    pub(crate) id: u32,
    /// `None` for a permanent activity.
    pub(crate) service: Option<ServiceIx>,
    pub(crate) task: TaskIx,
    pub(crate) marker: Arc<Marker>,
    pub(crate) stage: Stage,
    /// Who asked it to stop first, if it was asked.
    pub(crate) by: Option<String>,
    pub(crate) reply: Option<Reply>,
}

/// Control's ends of the rings to and from one task.
pub(crate) struct TaskLink {
    pub(crate) to: Producer<Box<Run>>,
    pub(crate) from: Consumer<Box<Run>>,
    pub(crate) notices: Option<Consumer<Notice>>,
    /// Activities of services that have a slot.
    pub(crate) used: usize,
}

/// Where an instance is in its life (genom3.md 7.2, 7.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Starting,
    Running,
    /// Activities were told to stop; no new ones.
    Stopping,
    Stopped,
}

/// How far a shutdown is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Activities of services, and requests under way, are to end (7.7.1).
    Activities,
    /// The permanent activity of this task is to end; those of the tasks after it have (7.7.2).
    Permanent(TaskIx),
    /// Codels that did not return in time may still do so, until the deadline of the shutdown.
    Rest,
    /// The threads are to end.
    Threads,
}

/// What control knows.
pub(crate) struct Control {
    pub(crate) phase: Phase,
    pub(crate) next_id: u32,
    /// In order of acceptance.
    pub(crate) entries: Vec<Entry>,
    pub(crate) services: Indexed<ServiceIx, ServiceQueue>,
    /// Services with a request that a worker may take.
    pub(crate) ready: VecDeque<ServiceIx>,
    pub(crate) links: Indexed<TaskIx, TaskLink>,
    /// Requests that workers are at.
    pub(crate) serving: usize,
    /// Free contexts of control workers.
    pub(crate) contexts: Vec<usize>,
    /// Workers that wait for a request.
    pub(crate) idle: usize,
    pub(crate) workers: Vec<std::thread::JoinHandle<()>>,
    /// Threads of tasks and workers that have not ended.
    pub(crate) alive: usize,
    /// How far a shutdown is, once it was asked for.
    pub(crate) step: Option<Step>,
    /// Who is to be told that it is over.
    pub(crate) ended: Option<OnShutdown>,
    /// The list of activities changed since the state port was written.
    pub(crate) dirty: bool,
    /// How a permanent activity failed.
    pub(crate) failure: Option<(TaskIx, Exception)>,
}

/// What is to be done once the lock is released, because replies and watchers may block.
#[derive(Default)]
pub(crate) struct Afterwards {
    pub(crate) replies: Vec<(Reply, Progress)>,
    pub(crate) changes: Vec<Change>,
    /// A permanent activity failed: the component is to be shut down.
    pub(crate) kill: bool,
}

impl Afterwards {
    /// An activity ends: tells its client and the watchers.
    pub(crate) fn ended(&mut self, entry: &mut Entry, outcome: Outcome) {
        if let Some(service) = entry.service {
            let exception = match &outcome {
                Outcome::Success(_) => None,
                Outcome::Exception(exception) => Some(exception.name.clone()),
            };
            self.changes.push(Change::Ended { activity: entry.id, service, exception });
        }
        if let Some(reply) = entry.reply.take() {
            self.replies.push((reply, Progress::Done(outcome)));
        }
    }
}

impl Entry {
    /// Whether its task executes it: started, and not ended.
    pub(crate) fn is_running(&self) -> bool {
        use crate::task::run::Status;
        matches!(self.stage, Stage::Sent) && self.marker.status() != Status::Init
    }
}

impl Control {
    pub(crate) fn new(plan: &Plan, links: Indexed<TaskIx, TaskLink>) -> Self {
        let tasks = plan.component().tasks.len();
        Self {
            phase: Phase::Starting,
            next_id: 1,
            entries: Vec::new(),
            services: plan.services().map(|_, _| ServiceQueue::default()),
            ready: VecDeque::new(),
            links,
            serving: 0,
            // Taken from the end.
            contexts: (tasks..plan.contexts()).rev().collect(),
            idle: 0,
            workers: Vec::new(),
            alive: 0,
            step: None,
            ended: None,
            dirty: true,
            failure: None,
        }
    }

    /// genom3.md 7.3.11: ids count from 1, permanent activities included.
    pub(crate) fn new_id(&mut self) -> u32 {
        let id = self.next_id;
        self.next_id = self.next_id.checked_add(1).unwrap_or(1);
        id
    }

    /// Hands a run to its task.
    pub(crate) fn send(&mut self, task: TaskIx, run: Box<Run>) {
        // The ring has room for every slot and the permanent activity.
        let _ = self.links[task].to.push(run);
    }
}

/// An exception of interface `genom`, which every service may end with.
pub(crate) fn genom(name: &str, detail: Value) -> Exception {
    Exception { name: format!("::genom::{name}"), detail }
}

/// genom3.md 7.5: told to stop, by this one.
pub(crate) fn interrupted(by: &str) -> Exception {
    genom("interrupted", json!({ "by": by }))
}

/// Whether control was asked to look; the next call says no until it is asked again.
pub(crate) fn take_attention(shared: &crate::shared::Shared) -> bool {
    shared.attention.swap(false, Ordering::AcqRel)
}
