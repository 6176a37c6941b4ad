//! A managed node: does what it is asked to through the control plane of the daemon.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use genom_doors::Own;
use genom_middleware::Publisher;
use genom_protocol::routes;
use genom_protocol::{
    Activity, CallEntry, CallParameters, CallReply, Code, ConnectionEntry, ConnectionRequest,
    Inputs, LookParameters, Reason, Status,
};
use genom_types::Record;
use serde_json::{Value, json};

use super::machine::{State, Transition, graph, states};
use super::managed::Managed;
use super::messages::Service;
use crate::offer::{Answers, unless_gone};

/// Why a transition failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}", .0.line())]
    Refused(Reason),
    #[error("{service} ended with {exception}")]
    Exception { service: String, exception: String },
    #[error("{service} still runs, {patience:?} after it was asked to stop")]
    Runs { service: String, patience: Duration },
}

impl From<Reason> for Failure {
    fn from(reason: Reason) -> Self {
        Self::Refused(reason)
    }
}

/// Publishes `~/transition_event`.
pub(crate) struct Events {
    pub(crate) publisher: Box<dyn Publisher>,
    pub(crate) message: Record,
}

/// A component as a node that ROS manages.
pub(crate) struct Node {
    what: Managed,
    plane: Own,
    /// How long an activity may take to stop.
    patience: Duration,
    now: Mutex<Now>,
    events: Mutex<Events>,
}

/// How the node is.
struct Now {
    state: State,
    /// What it is doing; one thing at a time.
    doing: Option<Transition>,
    /// What was started to activate it: numbers of activities.
    started: Vec<u64>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Answers<Service> for Node {
    fn name(&self) -> &str {
        &self.what.name
    }

    async fn answer(&self, service: Service, input: &Value) -> Value {
        match service {
            Service::ChangeState => json!({"success": self.change(&input["transition"]).await}),
            Service::GetState => {
                self.look().await;
                let now = lock(&self.now);
                let state = now.doing.map_or_else(|| now.state.message(), Transition::meanwhile);
                json!({"current_state": state})
            }
            Service::GetAvailableStates => json!({"available_states": states()}),
            Service::GetAvailableTransitions => {
                self.look().await;
                let now = lock(&self.now);
                // While it does one, no other is possible.
                let possible = now.state.transitions().filter(|_| now.doing.is_none());
                let possible: Vec<Value> = possible.map(|one| one.begin(now.state)).collect();
                json!({"available_transitions": possible})
            }
            Service::GetTransitionGraph => json!({"available_transitions": graph()}),
        }
    }
}

impl Node {
    pub(crate) fn new(what: Managed, plane: Own, patience: Duration, events: Events) -> Self {
        let now = Now { state: State::Unconfigured, doing: None, started: Vec::new() };
        Self { what, plane, patience, now: Mutex::new(now), events: Mutex::new(events) }
    }

    fn name(&self) -> &str {
        &self.what.name
    }

    /// Takes in what others did with the component: whoever uses the control plane can load and
    /// unload it, too.
    async fn look(&self) {
        let description = self.plane.ask(&routes::component(self.name()), None).await;
        let mut now = lock(&self.now);
        if now.doing.is_some() {
            return;
        }
        let state = match (now.state, description) {
            (State::Unconfigured, Ok(_)) => State::Inactive,
            (State::Inactive | State::Active, Err(why)) if why.is(Code::NoSuchComponent) => {
                State::Unconfigured
            }
            (state, _) => state,
        };
        if state != now.state {
            tracing::info!("{}: {} by others than ROS", self.name(), state.label());
            (now.state, now.started) = (state, Vec::new());
        }
    }

    /// Does what is asked. Returns whether it could be done.
    async fn change(&self, asked: &Value) -> bool {
        self.look().await;
        let (id, label) = (asked["id"].as_u64(), asked["label"].as_str());
        let (from, transition) = {
            let mut now = lock(&self.now);
            let from = now.state;
            let found = Transition::asked(id.unwrap_or_default(), label.unwrap_or_default(), from);
            let Some(transition) = found.filter(|_| now.doing.is_none()) else {
                let doing = now.doing.map_or_else(|| from.label(), Transition::label);
                tracing::warn!(
                    "{}: ROS asks for {asked}, which is not possible: {doing}",
                    self.name()
                );
                return false;
            };
            now.doing = Some(transition);
            (from, transition)
        };
        self.tell(&transition.begin(from));
        let done = match transition {
            Transition::Configure => self.configure().await,
            Transition::Activate => self.activate().await,
            Transition::Deactivate => self.deactivate().await,
            Transition::CleanUp => self.unload().await,
            Transition::Shutdown => self.shut_down(from).await,
        };
        let success = done.is_ok();
        let to = transition.leads(from, success);
        match done {
            Ok(()) => tracing::info!("{}: {}, as ROS asked", self.name(), to.label()),
            Err(why) => tracing::error!("{}: {} failed: {why}", self.name(), transition.label()),
        }
        {
            let mut now = lock(&self.now);
            (now.state, now.doing) = (to, None);
        }
        self.tell(&transition.end(from, success));
        success
    }

    /// Publishes an event.
    fn tell(&self, description: &Value) {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let mut event = description.clone();
        // `rcl_lifecycle` has nanoseconds of the system's clock there.
        event["timestamp"] = u64::try_from(since.as_nanos()).unwrap_or(u64::MAX).into();
        let events = &mut *lock(&self.events);
        let put = events.message.merge_json(&event).map_err(|error| error.to_string());
        let told = put.and_then(|()| {
            events.publisher.publish(&events.message).map_err(|error| error.to_string())
        });
        if let Err(why) = told {
            tracing::warn!("{}: an event of its lifecycle is not told: {why}", self.name());
        }
    }

    async fn call(&self, call: &CallEntry, wait: bool) -> Result<CallReply, Failure> {
        let route = routes::call(self.name(), &call.service);
        let route = route.with(&CallParameters { wait, ..CallParameters::default() });
        let reply = self.plane.ask(&route, Some(&Inputs(call.inputs.clone()))).await?;
        match reply.outcome().and_then(|outcome| outcome.exception.clone()) {
            Some(exception) => Err(Failure::Exception { service: call.service.clone(), exception }),
            None => Ok(reply),
        }
    }

    /// Loads the component, connects it, and makes the calls of the deployment. What began is undone
    /// if that fails.
    async fn configure(&self) -> Result<(), Failure> {
        self.plane.ask(&routes::load(), Some(&self.what.load)).await?;
        let set = self.set_up().await;
        if set.is_err() {
            self.unload().await?;
        }
        set
    }

    async fn set_up(&self) -> Result<(), Failure> {
        for entry in &self.what.connections {
            let ConnectionEntry { inport, outport, policy, over } = entry.clone();
            // Whatever it reads may be configured later.
            let request = ConnectionRequest { inport, outport, policy, over, wait: true };
            self.plane.ask(&routes::connect(), Some(&request)).await?;
        }
        for call in &self.what.calls {
            self.call(call, true).await?;
        }
        Ok(())
    }

    /// Starts the activities of the deployment; all or none.
    async fn activate(&self) -> Result<(), Failure> {
        for call in &self.what.activities {
            match self.call(call, false).await {
                Ok(reply) => lock(&self.now).started.extend(reply.activity()),
                Err(failure) => {
                    self.deactivate().await?;
                    return Err(failure);
                }
            }
        }
        Ok(())
    }

    /// Stops what was started, and waits until it has ended.
    async fn deactivate(&self) -> Result<(), Failure> {
        let started = lock(&self.now).started.clone();
        for number in &started {
            let route = routes::abort(self.name(), &number.to_string());
            unless_gone(self.plane.ask(&route, None).await)?;
        }
        let wait = Some(self.patience.as_secs_f64());
        for number in &started {
            let route = routes::activity(self.name(), &number.to_string());
            let looked = self.plane.ask(&route.with(&LookParameters { wait }), None).await;
            if let Ok(Activity { service, status: Status::Running, .. }) = looked {
                return Err(Failure::Runs { service, patience: self.patience });
            }
            unless_gone(looked)?;
        }
        lock(&self.now).started.clear();
        Ok(())
    }

    async fn unload(&self) -> Result<(), Failure> {
        Ok(unless_gone(self.plane.ask(&routes::unload(self.name()), None).await)?)
    }

    async fn shut_down(&self, from: State) -> Result<(), Failure> {
        if from == State::Active {
            self.deactivate().await?;
        }
        if from == State::Unconfigured { Ok(()) } else { self.unload().await }
    }
}
