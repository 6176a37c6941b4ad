//! Activities, each served as a ROS action.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::time::{SystemTime, UNIX_EPOCH};

use genom_kit::complaints::Complaints;
use genom_middleware::{
    ActivityId, CallError, Outcome, Replies, Served, ServiceHandler, ServiceType,
};

use crate::body::{self, ABORTED, CANCELED, Fields, GoalId, INTERRUPTED, SUCCEEDED, Style};
use crate::lock::lock;
use crate::nodes::Part;
use crate::rmw::{Claim, Gid, Reply, Rmw, ServerEnd, TopicWriter};

/// Number of finished goals whose results are kept for late requests.
const REMEMBERED: usize = 64;

/// `action_msgs/msg/GoalStatus`.
const ACCEPTED: u8 = 1;
const EXECUTING: u8 = 2;
const CANCELING: u8 = 3;

/// The services of an action.
pub(crate) struct Ends {
    pub(crate) send_goal: Box<dyn ServerEnd>,
    pub(crate) get_result: Box<dyn ServerEnd>,
    pub(crate) cancel_goal: Box<dyn ServerEnd>,
}

impl Ends {
    /// The first identifies the action.
    pub(crate) fn all(&self) -> [&dyn ServerEnd; 3] {
        [&*self.send_goal, &*self.get_result, &*self.cancel_goal]
    }
}

/// Feedback and status.
type Topics = (Arc<dyn TopicWriter>, Arc<dyn TopicWriter>);

/// An activity.
pub(crate) struct ActionServer {
    pub(crate) ty: ServiceType,
    pub(crate) style: Style,
    pub(crate) handler: Arc<dyn ServiceHandler>,
    pub(crate) topics: OnceLock<Topics>,
    goals: Mutex<Goals>,
    bad: Complaints,
}

#[derive(Default)]
struct Goals {
    by_id: HashMap<GoalId, Goal>,
    ended: VecDeque<GoalId>,
}

struct Goal {
    asker: Gid,
    /// The goal request, until it is answered.
    sent: Option<Box<dyn Reply>>,
    stamp: (i32, u32),
    status: u8,
    run: Option<ActivityId>,
    /// Status and outcome, once the goal has ended.
    result: Option<Vec<u8>>,
    /// Requests for the result that are not answered yet.
    waiting: Vec<Box<dyn Reply>>,
}

fn now() -> (i32, u32) {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    (i32::try_from(since.as_secs()).unwrap_or(i32::MAX), since.subsec_nanos())
}

fn put_info(out: &mut Vec<u8>, id: &GoalId, stamp: (i32, u32)) {
    out.extend_from_slice(id);
    // Numbers are aligned to 4 bytes.
    out.resize(out.len().next_multiple_of(4), 0);
    out.extend_from_slice(&stamp.0.to_le_bytes());
    out.extend_from_slice(&stamp.1.to_le_bytes());
}

fn answer_goal(by: Box<dyn Reply>, accepted: bool, stamp: (i32, u32)) {
    let mut reply = vec![u8::from(accepted), 0, 0, 0];
    reply.extend_from_slice(&stamp.0.to_le_bytes());
    reply.extend_from_slice(&stamp.1.to_le_bytes());
    by.send(reply);
}

impl ActionServer {
    pub(crate) fn new(
        ty: ServiceType,
        style: Style,
        handler: Arc<dyn ServiceHandler>,
    ) -> Arc<Self> {
        let (topics, goals) = (OnceLock::new(), Mutex::default());
        Arc::new(Self { ty, style, handler, topics, goals, bad: Complaints::default() })
    }

    /// Handles a goal request.
    pub(crate) fn send_goal(self: &Arc<Self>, by: Box<dyn Reply>, message: &[u8]) {
        let Some((fields, id)) = Fields::of(message).and_then(|mut fields| {
            let id = fields.bytes::<16>()?;
            Some((fields, id))
        }) else {
            if let Some(goals) = self.bad.add() {
                tracing::warn!(goals, "left out: without an id");
            }
            return;
        };
        let mut goals = lock(&self.goals);
        let input = fields.record(&self.ty.input);
        let input = match input {
            Ok(input) if !goals.by_id.contains_key(&id) => input,
            refused => {
                drop(goals);
                let why = refused.err().map(|error| error.to_string());
                if let Some(goals) = self.bad.add() {
                    tracing::warn!(why, goals, "refused: undecodable, or their id is in use");
                }
                return answer_goal(by, false, now());
            }
        };
        goals.by_id.insert(
            id,
            Goal {
                asker: by.asker(),
                sent: Some(by),
                stamp: now(),
                status: ACCEPTED,
                run: None,
                result: None,
                waiting: Vec::new(),
            },
        );
        drop(goals);
        // The handler may call back into this middleware, so no lock is held here.
        let replies = ToGoal { server: Arc::downgrade(self), id, ended: false };
        self.handler.request(input, Box::new(replies));
    }

    /// Handles a request for the result of a goal.
    pub(crate) fn get_result(&self, by: Box<dyn Reply>, message: &[u8]) {
        let Some(id) = Fields::of(message).and_then(|mut fields| fields.bytes::<16>()) else {
            return;
        };
        let mut goals = lock(&self.goals);
        let result = match goals.by_id.get_mut(&id) {
            Some(goal) if goal.result.is_none() => return goal.waiting.push(by),
            Some(goal) => goal.result.clone().unwrap_or_default(),
            None => {
                let mut unknown = vec![0];
                let outcome = Outcome::Lost(CallError::Gone);
                body::put_outcome(&mut unknown, &self.ty.output, &outcome, self.style);
                unknown
            }
        };
        drop(goals);
        by.send(result);
    }

    /// Handles a request to cancel one goal, all goals, or all up to a time
    /// (`action_msgs/srv/CancelGoal`).
    pub(crate) fn cancel_goal(&self, by: Box<dyn Reply>, message: &[u8]) {
        let wanted = Fields::of(message).and_then(|mut fields| {
            let id = fields.bytes::<16>()?;
            Some((id, (fields.word()?.cast_signed(), fields.word()?)))
        });
        let Some((wanted, until)) = wanted else { return };
        let mut canceling = Vec::new();
        let mut goals = lock(&self.goals);
        for (id, goal) in &mut goals.by_id {
            let meant = *id == wanted
                || (wanted == GoalId::default() && until == (0, 0))
                || (until != (0, 0) && goal.stamp <= until);
            if meant && goal.result.is_none() {
                goal.status = CANCELING;
                canceling.push((*id, goal.stamp, goal.run));
            }
        }
        let known = goals.by_id.contains_key(&wanted) || wanted == GoalId::default();
        drop(goals);
        for run in canceling.iter().filter_map(|(_, _, run)| *run) {
            self.handler.cancel(run);
        }
        // action_msgs/srv/CancelGoal: 0 some are canceling, 2 unknown goal, 3 goal has ended.
        let code = match (canceling.is_empty(), known) {
            (false, _) => 0,
            (true, false) => 2,
            (true, true) => 3,
        };
        let mut reply = vec![code, 0, 0, 0];
        reply.extend_from_slice(&u32::try_from(canceling.len()).unwrap_or(0).to_le_bytes());
        canceling.iter().for_each(|(id, stamp, _)| put_info(&mut reply, id, *stamp));
        by.send(reply);
        self.tell_status();
    }

    /// Publishes the status of all goals.
    fn tell_status(&self) {
        let goals = lock(&self.goals);
        let mut message = u32::try_from(goals.by_id.len()).unwrap_or(0).to_le_bytes().to_vec();
        for (id, goal) in &goals.by_id {
            put_info(&mut message, id, goal.stamp);
            message.push(goal.status);
        }
        drop(goals);
        if let Some((_, status)) = self.topics.get() {
            status.send(None, message);
        }
    }

    fn accepted(&self, id: &GoalId, run: Option<ActivityId>) {
        let mut goals = lock(&self.goals);
        let Some(goal) = goals.by_id.get_mut(id) else { return };
        goal.run = run.or(goal.run);
        let (sent, stamp) = (goal.sent.take(), goal.stamp);
        // It was cancelled before the activity had an id; the cancellation is passed on now.
        let cancelled = run.filter(|_| goal.status == CANCELING);
        drop(goals);
        if let Some(by) = sent {
            answer_goal(by, true, stamp);
            self.tell_status();
        }
        cancelled.into_iter().for_each(|run| self.handler.cancel(run));
    }

    fn feedback(&self, id: &GoalId, state: &str) {
        let mut goals = lock(&self.goals);
        let Some(goal) = goals.by_id.get_mut(id) else { return };
        let (asker, begins) = (goal.asker, goal.status == ACCEPTED);
        if begins {
            goal.status = EXECUTING;
        }
        drop(goals);
        if begins {
            self.tell_status();
        }
        if matches!(self.style, Style::Foreign(manner) if !manner.states) {
            // The feedback of a foreign type cannot express the state.
            return;
        }
        let mut message = id.to_vec();
        body::put_string(&mut message, state);
        if let Some((feedback, _)) = self.topics.get() {
            feedback.send(Some(asker), message);
        }
    }

    fn finish(&self, id: &GoalId, outcome: &Outcome) {
        // In ROS a goal must be accepted before it ends, even if it failed at once.
        self.accepted(id, None);
        let mut result = vec![0];
        body::put_outcome(&mut result, &self.ty.output, outcome, self.style);
        let mut goals = lock(&self.goals);
        let Some(goal) = goals.by_id.get_mut(id).filter(|goal| goal.result.is_none()) else {
            return;
        };
        let status = match outcome {
            // Cancelled, and it stopped in an orderly way (genom3.md 7.6).
            Outcome::Success(_) if goal.status == CANCELING => CANCELED,
            Outcome::Success(_) => SUCCEEDED,
            Outcome::Exception { name, .. } if name == INTERRUPTED => CANCELED,
            _ => ABORTED,
        };
        if let Some(first) = result.first_mut() {
            *first = status;
        }
        goal.status = status;
        goal.result = Some(result.clone());
        let waiting = std::mem::take(&mut goal.waiting);
        goals.ended.push_back(*id);
        if goals.ended.len() > REMEMBERED
            && let Some(oldest) = goals.ended.pop_front()
        {
            goals.by_id.remove(&oldest);
        }
        drop(goals);
        waiting.into_iter().for_each(|by| by.send(result.clone()));
        self.tell_status();
    }

    fn leave(&self) {
        let running: Vec<_> = lock(&self.goals)
            .by_id
            .iter()
            .filter(|(_, goal)| goal.result.is_none())
            .map(|(id, _)| *id)
            .collect();
        running.iter().for_each(|id| self.finish(id, &Outcome::Lost(CallError::Gone)));
    }
}

/// Passes the activity's replies on to the client.
struct ToGoal {
    server: Weak<ActionServer>,
    id: GoalId,
    ended: bool,
}

impl Replies for ToGoal {
    fn accepted(&mut self, id: ActivityId) {
        if let Some(server) = self.server.upgrade() {
            server.accepted(&self.id, Some(id));
        }
    }

    fn feedback(&mut self, state: &str) {
        if let Some(server) = self.server.upgrade() {
            server.feedback(&self.id, state);
        }
    }

    fn finish(mut self: Box<Self>, outcome: Outcome) {
        self.ended = true;
        if let Some(server) = self.server.upgrade() {
            server.finish(&self.id, &outcome);
        }
    }
}

impl Drop for ToGoal {
    fn drop(&mut self) {
        if let Some(server) = self.server.upgrade().filter(|_| !self.ended) {
            server.finish(&self.id, &Outcome::Lost(CallError::Gone));
        }
    }
}

/// Serves the activity until it is dropped.
pub(crate) struct Ros2Action {
    pub(crate) server: Arc<ActionServer>,
    pub(crate) ends: Ends,
    pub(crate) claim: Option<Box<dyn Claim>>,
    /// What it is to its node.
    pub(crate) part: Option<Part>,
    pub(crate) rmw: Arc<dyn Rmw>,
}

impl Served for Ros2Action {}

impl Drop for Ros2Action {
    fn drop(&mut self) {
        // Withdraw the service before answering the last requests.
        self.part = None;
        self.ends.all().iter().for_each(|end| end.withdraw());
        self.claim = None;
        self.rmw.settle();
        self.server.leave();
        self.ends.get_result.flush();
        self.ends.send_goal.flush();
        if let Some((feedback, _)) = self.server.topics.get() {
            feedback.flush();
        }
    }
}
