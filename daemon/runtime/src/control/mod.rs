//! Control: the state of requests, activities and shutdown, under one lock that no task takes.

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
use crate::rules::Seen;
use crate::shared::Notice;
use crate::task::run::{Marker, Run};
use crate::ticket::Ticket;
use crate::watcher::Change;

/// A request in the queue.
pub(crate) struct Request {
    pub(crate) inputs: Inputs,
    pub(crate) reply: Reply,
    pub(crate) ticket: Ticket,
}

/// The reply of a request being served: the first to take it answers, so that only one answer is
/// given.
#[derive(Clone)]
pub(crate) struct Asker(Arc<Mutex<Option<Reply>>>);

impl Asker {
    pub(crate) fn new(reply: Reply) -> Self {
        Self(Arc::new(Mutex::new(Some(reply))))
    }

    /// Takes the reply; `None` when it was taken before.
    pub(crate) fn take(&self) -> Option<Reply> {
        lock(&self.0).take()
    }
}

/// Queue of one service: its requests are served one at a time, in order of arrival.
#[derive(Default)]
pub(crate) struct ServiceQueue {
    pub(crate) waiting: VecDeque<Request>,
    /// A worker serves one of its requests.
    pub(crate) busy: bool,
    /// The reply of that request.
    pub(crate) asker: Option<Asker>,
    /// Was executed successfully at least once (genom3.md 7.6).
    pub(crate) ran: bool,
}

/// Stage of an activity, as control sees it.
pub(crate) enum Stage {
    /// The client is being informed of its id.
    Accepting,
    /// Waits until the activities that it interrupts have ended.
    Pending(Box<Run>),
    /// Passed to its task.
    Sent,
    /// Its client was answered; the task has still to return it.
    Cancelled,
    /// Its client was answered, and the entry can be removed.
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
    /// Name of who first asked it to stop, if anybody did.
    pub(crate) by: Option<String>,
    pub(crate) reply: Option<Reply>,
    /// When it was accepted, by the clock of the instance.
    pub(crate) accepted: u64,
    /// When it was asked to stop while it ran.
    pub(crate) asked: Option<u64>,
    /// A bit for each rule about its time that it has broken.
    pub(crate) late: u32,
}

/// Control's ends of the rings to and from one task.
pub(crate) struct TaskLink {
    pub(crate) to: Producer<Box<Run>>,
    pub(crate) from: Consumer<Box<Run>>,
    pub(crate) notices: Option<Consumer<Notice>>,
    pub(crate) broken: Option<Consumer<Seen>>,
    /// Slots taken by activities of services.
    pub(crate) used: usize,
}

/// Phase of an instance (genom3.md 7.2, 7.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Starting,
    Running,
    /// Activities were asked to stop; no new ones are accepted.
    Stopping,
    Stopped,
}

/// Steps of a shutdown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Waits for activities of services, and requests being served (7.7.1).
    Activities,
    /// Waits for the permanent activity of this task; those of later tasks have ended (7.7.2).
    Permanent(TaskIx),
    /// Waits for codels that did not return in time, until the deadline of the shutdown.
    Rest,
    /// The threads are asked to end.
    Threads,
}

/// State of control.
pub(crate) struct Control {
    pub(crate) phase: Phase,
    pub(crate) next_id: u32,
    /// Activities in order of acceptance.
    pub(crate) entries: Vec<Entry>,
    pub(crate) services: Indexed<ServiceIx, ServiceQueue>,
    /// Services that have a request for a worker.
    pub(crate) ready: VecDeque<ServiceIx>,
    pub(crate) links: Indexed<TaskIx, TaskLink>,
    /// Number of requests being served.
    pub(crate) serving: usize,
    /// Contexts of control workers that are free.
    pub(crate) contexts: Vec<usize>,
    /// Number of workers that wait for a request.
    pub(crate) idle: usize,
    pub(crate) workers: Vec<std::thread::JoinHandle<()>>,
    /// Number of threads of tasks and workers that have not ended.
    pub(crate) alive: usize,
    /// Current step of a shutdown, once one has begun.
    pub(crate) step: Option<Step>,
    /// Called when the shutdown is complete.
    pub(crate) ended: Option<OnShutdown>,
    /// The list of activities changed since the state port was last written.
    pub(crate) dirty: bool,
    /// Exception with which a permanent activity failed.
    pub(crate) failure: Option<(TaskIx, Exception)>,
}

/// Actions for after the lock is released, because replies and watchers may block.
#[derive(Default)]
pub(crate) struct Afterwards {
    pub(crate) replies: Vec<(Reply, Progress)>,
    pub(crate) changes: Vec<Change>,
    /// A permanent activity failed, so the component has to be shut down.
    pub(crate) kill: bool,
}

impl Afterwards {
    /// An activity ends: informs its client and the watchers.
    pub(crate) fn ended(&mut self, entry: &mut Entry, outcome: Outcome) {
        if let Some(service) = entry.service {
            let exception = match &outcome {
                Outcome::Success(_) => None,
                Outcome::Exception(exception) => Some(exception.name.clone()),
            };
            self.changes.push(Change::Ended { activity: entry.id, service, exception });
        }
        if let Some(reply) = entry.reply.take() {
            self.replies.push((reply, Progress::Ended(outcome)));
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
            // Contexts are popped from the end, so the first one is used first.
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

    /// genom3.md 7.3.11: ids count from 1 and include permanent activities.
    pub(crate) fn new_id(&mut self) -> u32 {
        let id = self.next_id;
        self.next_id = self.next_id.checked_add(1).unwrap_or(1);
        id
    }

    /// Sends a run to its task.
    pub(crate) fn send(&mut self, task: TaskIx, run: Box<Run>) {
        // The ring has room for every slot and the permanent activity.
        let _ = self.links[task].to.push(run);
    }
}

/// An exception of interface `genom`, which every service may throw.
pub(crate) fn genom(name: &str, detail: Value) -> Exception {
    Exception { name: format!("::genom::{name}"), detail }
}

/// genom3.md 7.5: the exception of an activity that was asked to stop.
pub(crate) fn interrupted(by: &str) -> Exception {
    genom("interrupted", json!({ "by": by }))
}

/// Whether control was asked to process something; resets the flag.
pub(crate) fn take_attention(shared: &crate::shared::Shared) -> bool {
    shared.attention.swap(false, Ordering::AcqRel)
}
