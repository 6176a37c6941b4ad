//! The calling ends of services and actions.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::time::{Duration, Instant};

use genom_middleware::describe::types_of_service;
use genom_middleware::reply::pair;
use genom_middleware::{
    ActivityId, Address, CallError, Client, Outcome, Replies, Running, ServiceHandler, ServiceType,
};
use genom_types::Record;
use rustdds::Timestamp;
use rustdds::mio1::Token;

use crate::backend::Core;
use crate::body::{self, Fields, Style};
use crate::channel::{Answer, ClientEnd};
use crate::goals::GoalId;
use crate::graph::{Service, Wanted};
use crate::post::{Prefix, Target, prefix};
use crate::receiver::{Inlet, Sample, Sink};
use crate::server::lock;

/// Feedback that comes before its goal was accepted; more is given up.
const EARLY: usize = 64;

/// For so long after it was opened, the first call waits for a service to become known.
pub(crate) const ACQUAINTANCE: Duration = Duration::from_secs(2);

/// Goals sent by this process so far.
static GOALS: AtomicU64 = AtomicU64::new(0);

/// How a service is called.
#[derive(Clone)]
pub(crate) enum Way {
    Service(Arc<ClientEnd>),
    Action(Arc<ActionEnd>),
}

/// The calling end of a service.
pub(crate) struct Ros2Client {
    pub(crate) at: Address,
    pub(crate) ty: ServiceType,
    pub(crate) style: Style,
    pub(crate) wanted: Wanted,
    pub(crate) way: Way,
    /// Until then a service that is not known yet may be about to be.
    pub(crate) acquainted: Instant,
    pub(crate) core: Arc<Core>,
}

/// The calling end of an action, shared by all callers of it in this daemon.
pub(crate) struct ActionEnd {
    pub(crate) send_goal: ClientEnd,
    pub(crate) get_result: ClientEnd,
    pub(crate) cancel_goal: ClientEnd,
    pub(crate) runs: Arc<Runs>,
    pub(crate) feedback: Token,
    pub(crate) inlet: Arc<Inlet>,
    /// Sets the goals of this daemon apart from others.
    pub(crate) mark: [u8; 8],
}

impl Drop for ActionEnd {
    fn drop(&mut self) {
        self.inlet.remove(self.feedback);
    }
}

/// Goals under way, by id.
#[derive(Default)]
pub(crate) struct Runs(Mutex<HashMap<GoalId, Weak<Run>>>);

/// One goal under way.
struct Run {
    at: Address,
    ty: ServiceType,
    style: Style,
    id: GoalId,
    server: Target,
    /// Weak: what waits in the ends holds this.
    action: Weak<ActionEnd>,
    state: Mutex<RunState>,
}

#[derive(Default)]
struct RunState {
    /// Taken when it ended.
    replies: Option<Box<dyn Replies>>,
    accepted: bool,
    cancelled: bool,
    early: Vec<String>,
}

/// Takes the feedback of an action.
pub(crate) struct Feedback {
    pub(crate) runs: Arc<Runs>,
    pub(crate) since: Timestamp,
}

impl Sink for Feedback {
    fn arrive(&mut self, sample: Sample<'_>) {
        if sample.received < self.since {
            return;
        }
        let Some(mut fields) = Fields::of(sample.message) else { return };
        let Some(id) = fields.bytes::<16>() else { return };
        let run = lock(&self.runs.0).get(&id).and_then(Weak::upgrade);
        // That of a foreign type may be something else.
        let run = run.filter(|run| !matches!(run.style, Style::Foreign(m) if !m.states));
        if let Some(run) = run
            && let Some(state) = fields.string()
        {
            run.feedback(state);
        }
    }
}

impl Ros2Client {
    fn mismatch(&self, theirs: String) -> CallError {
        let ours = types_of_service(&self.ty);
        CallError::TypeMismatch { address: self.at.clone(), ours, theirs }
    }
}

impl Client for Ros2Client {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        self.send(input, replies, self.acquainted)
    }

    fn call(&mut self, input: &Record, timeout: Duration) -> Result<Outcome, CallError> {
        let (replies, reply) = pair();
        let begun = Instant::now();
        let end = begun.checked_add(timeout).unwrap_or(self.acquainted).min(self.acquainted);
        let _running = self.send(input, Box::new(replies), end)?;
        reply.wait(timeout.saturating_sub(begun.elapsed())).map_err(|error| match error {
            CallError::Timeout(_) => CallError::Timeout(timeout),
            error => error,
        })
    }
}

impl Ros2Client {
    /// Sends a request; until `end` a service that is not known yet is waited for.
    fn send(
        &self,
        input: &Record,
        replies: Box<dyn Replies>,
        end: Instant,
    ) -> Result<Box<dyn Running>, CallError> {
        let reader = match self.core.graph.service(&self.wanted, end) {
            Service::There(reader) => reader,
            Service::Nobody => return Err(CallError::Nobody { address: self.at.clone() }),
            Service::Differs(theirs) => return Err(self.mismatch(theirs)),
        };
        if !input.ty().same_as(&self.ty.input) {
            return Err(self.mismatch(types_of_service(&self.ty)));
        }
        let Some(reader) = reader else {
            // Of this daemon: DDS shows a participant to itself only over multicast.
            let handler = self.core.own_service(&self.wanted.topic);
            let handler = handler.ok_or(CallError::Nobody { address: self.at.clone() })?;
            return Ok(Within::request(handler, input, replies));
        };
        let undecodable =
            |error: genom_types::CdrError| CallError::Serialization(error.to_string());
        match &self.way {
            Way::Service(end) => {
                let mut body = Vec::new();
                body::put_input(&mut body, input).map_err(undecodable)?;
                let (output, style) = (self.ty.output.clone(), self.style);
                let then = move |reply: Result<&[u8], CallError>| {
                    replies.finish(match reply.map(Fields::of) {
                        Ok(Some(mut fields)) => fields.outcome(&output, style, None),
                        Ok(None) => Outcome::Lost(CallError::Serialization("it is empty".into())),
                        Err(error) => Outcome::Lost(error),
                    });
                };
                end.call(Target::Reader(reader), body, Answer::new(then));
                Ok(Box::new(Nothing))
            }
            Way::Action(action) => {
                let run = Run::new(self, action, prefix(&reader), replies);
                let mut body = run.id.to_vec();
                body::put_input(&mut body, input).map_err(undecodable)?;
                lock(&action.runs.0).insert(run.id, Arc::downgrade(&run));
                let goal = Arc::clone(&run);
                let answer = Answer::new(move |reply| goal.answered(reply));
                action.send_goal.call(Target::Reader(reader), body, answer);
                Ok(Box::new(Underway(run)))
            }
        }
    }
}

/// Attributes and functions cannot be cancelled.
struct Nothing;

impl Running for Nothing {
    fn cancel(&self) {}
}

impl Run {
    fn new(
        client: &Ros2Client,
        action: &Arc<ActionEnd>,
        server: Prefix,
        replies: Box<dyn Replies>,
    ) -> Arc<Self> {
        let number = GOALS.fetch_add(1, Ordering::Relaxed) + 1;
        let mut id = GoalId::default();
        let bytes = action.mark.iter().copied().chain(number.to_le_bytes());
        id.iter_mut().zip(bytes).for_each(|(to, byte)| *to = byte);
        Arc::new(Self {
            at: client.at.clone(),
            ty: client.ty.clone(),
            style: client.style,
            id,
            server: Target::Participant(server),
            action: Arc::downgrade(action),
            state: Mutex::new(RunState { replies: Some(replies), ..RunState::default() }),
        })
    }

    /// The number of a goal, as this side counts: ROS tells no other.
    fn number(&self) -> u64 {
        self.id.last_chunk().map_or(0, |number| u64::from_le_bytes(*number))
    }

    fn finish(&self, outcome: Outcome) {
        if let Some(action) = self.action.upgrade() {
            lock(&action.runs.0).remove(&self.id);
        }
        let replies = lock(&self.state).replies.take();
        if let Some(replies) = replies {
            replies.finish(outcome);
        }
    }

    fn answered(self: &Arc<Self>, reply: Result<&[u8], CallError>) {
        let accepted = match reply.map(|reply| Fields::of(reply).and_then(|mut f| f.byte())) {
            Ok(Some(accepted)) => accepted != 0,
            Ok(None) => {
                let error = CallError::Serialization("the answer to a goal is cut".to_owned());
                return self.finish(Outcome::Lost(error));
            }
            Err(error) => return self.finish(Outcome::Lost(error)),
        };
        if !accepted {
            let why = format!("{} refused the goal; its own log says why", self.at);
            let error = CallError::Failed { backend: "ros2".to_owned(), why };
            return self.finish(Outcome::Lost(error));
        }
        let mut state = lock(&self.state);
        state.accepted = true;
        let early = std::mem::take(&mut state.early);
        if let Some(replies) = &mut state.replies {
            replies.accepted(ActivityId(self.number()));
            early.iter().for_each(|state| replies.feedback(state));
        }
        let cancelled = state.cancelled;
        drop(state);
        let run = Arc::clone(self);
        let then = move |reply: Result<&[u8], CallError>| {
            run.finish(match reply.map(Fields::of) {
                Ok(Some(mut fields)) => match fields.byte() {
                    status @ Some(_) => fields.outcome(&run.ty.output, run.style, status),
                    None => Outcome::Lost(CallError::Serialization("it is empty".into())),
                },
                Ok(None) => Outcome::Lost(CallError::Serialization("it is empty".into())),
                Err(error) => Outcome::Lost(error),
            });
        };
        let answer = Answer::new(then);
        let Some(action) = self.action.upgrade() else { return };
        action.get_result.call(self.server, self.id.to_vec(), answer);
        if cancelled {
            self.ask_to_cancel();
        }
    }

    fn feedback(&self, name: &str) {
        let mut state = lock(&self.state);
        if !state.accepted {
            if state.early.len() < EARLY {
                state.early.push(name.to_owned());
            }
        } else if let Some(replies) = &mut state.replies {
            replies.feedback(name);
        }
    }

    fn ask_to_cancel(&self) {
        let mut body = self.id.to_vec();
        body.extend_from_slice(&[0; 8]);
        if let Some(action) = self.action.upgrade() {
            action.cancel_goal.call(self.server, body, Answer::new(|_| {}));
        }
    }
}

/// Keeps the way to cancel.
struct Underway(Arc<Run>);

impl Running for Underway {
    fn cancel(&self) {
        let mut state = lock(&self.0.state);
        state.cancelled = true;
        let now = state.accepted && state.replies.is_some();
        drop(state);
        if now {
            self.0.ask_to_cancel();
        }
    }
}

/// A request to a service of this daemon, handed straight through.
struct Within {
    handler: Weak<dyn ServiceHandler>,
    id: Arc<OnceLock<ActivityId>>,
}

struct Noting {
    replies: Option<Box<dyn Replies>>,
    id: Arc<OnceLock<ActivityId>>,
}

impl Within {
    fn request(
        handler: Arc<dyn ServiceHandler>,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Box<dyn Running> {
        let id = Arc::new(OnceLock::new());
        let noting = Noting { replies: Some(replies), id: Arc::clone(&id) };
        handler.request(input.clone(), Box::new(noting));
        Box::new(Self { handler: Arc::downgrade(&handler), id })
    }
}

impl Replies for Noting {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.id.set(id);
        if let Some(replies) = &mut self.replies {
            replies.accepted(id);
        }
    }

    fn feedback(&mut self, state: &str) {
        if let Some(replies) = &mut self.replies {
            replies.feedback(state);
        }
    }

    fn finish(mut self: Box<Self>, outcome: Outcome) {
        if let Some(replies) = self.replies.take() {
            replies.finish(outcome);
        }
    }
}

impl Drop for Noting {
    fn drop(&mut self) {
        if let Some(replies) = self.replies.take() {
            replies.finish(Outcome::Lost(CallError::Gone));
        }
    }
}

impl Running for Within {
    fn cancel(&self) {
        if let (Some(id), Some(handler)) = (self.id.get(), self.handler.upgrade()) {
            handler.cancel(*id);
        }
    }
}
