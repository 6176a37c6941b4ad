//! The calling end of an action, and its goals in progress.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Weak};

use genom_middleware::{ActivityId, Address, CallError, Outcome, Replies, Running, ServiceType};

use crate::body::{Fields, GoalId, Style};
use crate::error::BACKEND;
use crate::lock::lock;
use crate::rmw::{Answer, ClientEnd, Gid, Target};

/// Feedback that arrives before its goal was accepted; more than this is dropped.
const EARLY: usize = 64;

/// Number of goals that this process has sent.
static GOALS: AtomicU64 = AtomicU64::new(0);

/// The calling end of an action, shared by all callers of it in this daemon.
pub(crate) struct ActionEnd {
    #[allow(dead_code, reason = "to be there is what it does")]
    pub(crate) feedback: Box<dyn Send + Sync>,
    pub(crate) send_goal: Box<dyn ClientEnd>,
    pub(crate) get_result: Box<dyn ClientEnd>,
    pub(crate) cancel_goal: Box<dyn ClientEnd>,
    pub(crate) runs: Arc<Runs>,
    /// Distinguishes the goals of this daemon from others.
    pub(crate) mark: [u8; 8],
}

/// Goals in progress, by id.
#[derive(Default)]
pub(crate) struct Runs(Mutex<HashMap<GoalId, Weak<Run>>>);

/// A goal in progress.
pub(crate) struct Run {
    at: Address,
    ty: ServiceType,
    style: Style,
    id: GoalId,
    server: Target,
    /// Weak, because the pending replies of the ends hold this run.
    action: Weak<ActionEnd>,
    state: Mutex<RunState>,
}

#[derive(Default)]
struct RunState {
    /// Taken when the goal ends.
    replies: Option<Box<dyn Replies>>,
    accepted: bool,
    cancelled: bool,
    early: Vec<String>,
}

impl Runs {
    /// Receives feedback of the action.
    pub(crate) fn feedback(&self, message: &[u8]) {
        let Some(mut fields) = Fields::of(message) else { return };
        let Some(id) = fields.bytes::<16>() else { return };
        let run = lock(&self.0).get(&id).and_then(Weak::upgrade);
        // The feedback of a foreign type may be something other than a state.
        let run = run.filter(|run| !matches!(run.style, Style::Foreign(m) if !m.states));
        if let Some(run) = run
            && let Some(state) = fields.string()
        {
            run.feedback(state);
        }
    }
}

impl Run {
    /// A goal of this activity for the action of that server.
    pub(crate) fn new(
        (at, ty, style): (&Address, &ServiceType, Style),
        action: &Arc<ActionEnd>,
        server: Gid,
    ) -> Arc<Self> {
        let number = GOALS.fetch_add(1, Ordering::Relaxed) + 1;
        let mut id = GoalId::default();
        let bytes = action.mark.iter().copied().chain(number.to_le_bytes());
        id.iter_mut().zip(bytes).for_each(|(to, byte)| *to = byte);
        Arc::new(Self {
            at: at.clone(),
            ty: ty.clone(),
            style,
            id,
            server: Target::Beside(server),
            action: Arc::downgrade(action),
            state: Mutex::default(),
        })
    }

    pub(crate) fn id(&self) -> &GoalId {
        &self.id
    }

    /// Sends the goal as soon as the server's reader is connected.
    pub(crate) fn begin(
        self: Arc<Self>,
        replies: Box<dyn Replies>,
        to: Target,
        body: Vec<u8>,
    ) -> Box<dyn Running> {
        lock(&self.state).replies = Some(replies);
        if let Some(action) = self.action.upgrade() {
            lock(&action.runs.0).insert(self.id, Arc::downgrade(&self));
            let goal = Arc::clone(&self);
            let answer = Answer::new(move |reply| goal.answered(reply));
            action.send_goal.call(to, body, answer);
        }
        Box::new(Underway(self))
    }

    /// The activity id of a goal. ROS identifies goals by random ids, so this side numbers them.
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
            let error = CallError::Failed { backend: BACKEND.to_owned(), why };
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

/// Allows cancelling the goal.
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
