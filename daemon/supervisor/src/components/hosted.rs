//! A running component: the runtime's instance, and the state that supervisors need about it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use genom_description::model::{
    Component as Model, Direction, PortIx, RemoteIx, ServiceIx, ServiceKind, Specification,
};
use genom_host::Component;
use genom_middleware::{Address, Publisher, Quality, Served, Subscription};
use genom_ports::PortKey;
use genom_runtime::body::{Body, RemoteCall};
use genom_runtime::plan::Plan;
use genom_runtime::{
    ActivityPhase, CannotWait, Clock, HeldUp, Instance, Options, Progress, RunningCodel,
    StartError, Statistics, TaskHistograms, Ticket, Watcher, seconds,
};
use genom_types::{DataType, Record};
use serde_json::Value;

use super::activities::{Activity, ActivityLog};
use super::build::Build;
use super::guard::Guard;
use super::input::{Asked, InputError};
use super::prepared::Prepared;
use super::spins::{Spin, Spins, times_of};
use super::standing::Standing;
use super::tracked::{Tracked, held, resume};
use super::turn::Turn;
use super::watch::{BusWatcher, Follower};
use crate::outcome::Outcome;
use crate::recording::Recordings;
use crate::spans;
use crate::ties::Ties;
use genom_bus::Bus;
use genom_bus::flag::Flag;
use genom_configuration::BackendNames;

/// The first reply to a request.
#[derive(Debug)]
pub enum Answer {
    /// The outcome of an attribute or a function, or of an activity that was not accepted.
    Ended(Outcome),
    /// An activity was accepted.
    Accepted(Arc<Activity>),
    /// The component stopped before it replied.
    Gone,
    /// A stuck codel blocks the request: it was withdrawn and will not be executed.
    HeldUp(HeldUp),
    /// The inputs cannot be combined with the present values of the component. Nothing was changed.
    Refused(InputError),
}

/// The services of one component as offered to others, by name of the middleware.
pub type ServedOn = Vec<(String, ServedServices)>;

/// Services offered on one middleware.
pub type ServedServices = Vec<(ServiceIx, Box<dyn Served>)>;

/// A running component.
pub struct Hosted {
    /// Instance name.
    pub name: String,
    /// What it runs.
    pub(super) build: Mutex<Build>,
    /// Its code and memory.
    pub(super) component: Arc<Component>,
    /// Whether its library is being exchanged.
    pub(super) reloading: Arc<Turn>,
    /// Its activities: running, and recently ended.
    pub activities: Arc<ActivityLog>,
    /// The connections of its ports and remotes.
    pub ties: Arc<Ties>,
    /// Requests whose effect lasts: they are written into dumps.
    pub standing: Arc<Standing>,
    /// What was not taken over as it was when its state was put back.
    pub notes: Vec<String>,
    /// Raised when it is unloaded, to end streams.
    pub gone: Flag,
    /// Raised when it asked to be unloaded (service `kill`).
    pub killed: Flag,
    pub(super) recordings: Arc<Recordings>,
    /// With a virtual clock, requests are executed by the thread that sends them.
    pub(super) serves_at_once: bool,
    plan: Arc<Plan>,
    pub(super) instance: Instance,
    pub(super) watcher: Arc<BusWatcher>,
    pub(super) guard: Arc<Guard>,
    spins: Mutex<Spins>,
    /// Its services as offered on middlewares.
    pub(super) served: Mutex<ServedOn>,
}

/// What is needed to start a component.
pub struct Starting {
    /// Instance name.
    pub name: String,
    /// What it runs.
    pub build: Build,
    /// The component in compiled form.
    pub plan: Arc<Plan>,
    /// The connections of its ports and remotes.
    pub ties: Arc<Ties>,
    /// Raised when it asks to be unloaded (service `kill`).
    pub killed: Flag,
    /// Where its changes are reported.
    pub bus: Arc<Bus>,
    /// What it is supervised by.
    pub guard: Guard,
    /// The running recordings.
    pub recordings: Arc<Recordings>,
    /// How long the results of its activities are kept.
    pub keep_results: Duration,
    /// The state where it is to go on.
    pub(crate) prepared: Option<Prepared>,
    /// The one whose place it takes: it is held until that is handed over.
    pub(crate) before: Option<Arc<Hosted>>,
}

impl Hosted {
    /// Starts the tasks and waits for their start codels. The ports must be bound already.
    pub fn start(
        starting: Starting,
        component: Arc<Component>,
        mut options: Options,
    ) -> Result<Self, StartError> {
        let Starting { name, build, plan, ties, killed, prepared, before, .. } = starting;
        let (activities, standing) = match &before {
            Some(before) => (Arc::clone(&before.activities), Arc::clone(&before.standing)),
            None => (Arc::new(ActivityLog::new(starting.keep_results)), Arc::default()),
        };
        let mut notes = Vec::new();
        options.resume = prepared.map(|mut prepared| {
            notes = std::mem::take(&mut prepared.notes);
            for call in &prepared.deployed {
                standing.deployed(&call.service, call.inputs.clone());
            }
            resume(prepared, &name, &activities, &standing, &|_| false)
        });
        if let Some(before) = &before {
            options.resume = Some(held());
            options.epoch = Some(before.instance.epoch());
        }
        let serves_at_once = matches!(options.clock, Clock::Virtual(_));
        let guard = Arc::new(starting.guard);
        let watcher = Arc::new(BusWatcher::new(&starting.bus, &name, &plan, &guard));
        options.watcher = Some(Arc::clone(&watcher) as Arc<dyn Watcher>);
        let body: Arc<dyn Body> = Arc::clone(&component) as _;
        let instance = Instance::start(Arc::clone(&plan), body, options)?;
        notes.extend(instance.unresumed());
        Ok(Self {
            name,
            build: Mutex::new(build),
            component,
            reloading: Arc::default(),
            activities,
            ties,
            standing,
            notes,
            gone: Flag::new(),
            killed,
            recordings: starting.recordings,
            serves_at_once,
            plan,
            instance,
            watcher,
            guard,
            spins: Mutex::default(),
            served: Mutex::default(),
        })
    }

    /// Adds services offered on further middlewares, and withdraws them from middlewares that are
    /// not in `stay`.
    pub fn serve_also(&self, served: ServedOn, stay: &BackendNames) {
        let mut all = self.served.lock().unwrap_or_else(PoisonError::into_inner);
        all.extend(served);
        let gone: ServedOn = all.extract_if(.., |(name, _)| !stay.has(name)).collect();
        drop(all);
        // Dropped after the new ones were added and the lock is released, so that nobody waits.
        drop(gone);
    }

    /// The middlewares that a service is offered on.
    pub fn served_on(&self, service: ServiceIx) -> Vec<String> {
        let all = self.served.lock().unwrap_or_else(PoisonError::into_inner);
        let there = all.iter().filter(|(_, served)| served.iter().any(|(one, _)| *one == service));
        there.map(|(name, _)| name.clone()).collect()
    }

    /// The component's description.
    pub fn model(&self) -> &Model {
        self.plan.component()
    }

    /// The whole specification that the component comes from.
    pub fn specification(&self) -> &Specification {
        self.plan.specification()
    }

    /// The component in compiled form.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Address of a port or service, or of an element of a multiple port.
    pub fn address(&self, name: &str, element: Option<&str>) -> Address {
        match element {
            Some(element) => Address::new(self.name.as_str(), format!("{name}/{element}")),
            None => Address::new(self.name.as_str(), name),
        }
    }

    /// Type of a port's data.
    pub fn port_type(&self, port: PortIx) -> Option<&DataType> {
        self.plan.port_type(port)
    }

    /// Address of a port, or of an element of a multiple one.
    pub fn port_address(&self, key: &PortKey) -> Address {
        self.address(&self.model().ports[key.port].name, key.element())
    }

    /// The port itself or, if it is multiple, its elements.
    pub fn elements(&self, port: PortIx) -> Vec<PortKey> {
        if self.model().ports[port].multiple {
            let elements = self.ties.elements(port).into_iter();
            elements.map(|element| PortKey { port, element: Some(element) }).collect()
        } else {
            vec![PortKey::new(port, None)]
        }
    }

    /// The middlewares that a port is on, also those only as long as connections need that.
    pub fn backends_of(&self, key: &PortKey) -> BackendNames {
        self.own_backends_of(key).with(&self.ties.lent(key))
    }

    /// The middlewares that a port is on, whoever is connected to it.
    pub(crate) fn own_backends_of(&self, key: &PortKey) -> BackendNames {
        self.ties.bindings.port(&self.model().ports[key.port].name)
    }

    /// The quality of service requested for a port, on any middleware.
    pub fn quality(&self, key: &PortKey) -> Quality {
        self.ties.bindings.quality(&self.model().ports[key.port].name)
    }

    /// Last value of a port.
    pub fn port_value(&self, key: &PortKey) -> Option<Value> {
        self.instance.port_value(key.port, key.element())
    }

    /// The last value of a port as a record, unchanged bit by bit. `None` also if no copy was kept,
    /// as for large values that nobody watches.
    pub fn last_value(&self, key: &PortKey) -> Option<Record> {
        self.instance.last_value(key.port, key.element())
    }

    /// The last value of a port as a CDR message.
    pub fn port_message(&self, key: &PortKey) -> Option<Vec<u8>> {
        self.instance.port_message(key.port, key.element())
    }

    /// Sends a request. `progress` is called with its progress, by the control threads of the
    /// component.
    pub fn submit(
        &self,
        service: ServiceIx,
        input: Record,
        progress: impl FnMut(Heard) + Send + 'static,
    ) {
        self.submit_by(&Ticket::default(), service, Asked::Whole(input), progress);
    }

    /// The same; with the ticket the request can be withdrawn.
    pub(super) fn submit_by(
        &self,
        ticket: &Ticket,
        service: ServiceIx,
        asked: Asked,
        mut progress: impl FnMut(Heard) + Send + 'static,
    ) {
        let name = &self.model().services[service].name;
        let told = || match &asked {
            Asked::Whole(input) => input.to_json(),
            Asked::Partial(given) => given.clone(),
        };
        let call = self.recordings.called(&self.name, name, told);
        let inputs = self.remembered(service).then(told);
        let (asked, completion) = self.inputs(service, asked);
        let mut tracked = Tracked {
            span: spans::service(&self.name, name),
            call,
            log: Arc::clone(&self.activities),
            service: name.clone(),
            running: None,
            standing: Arc::clone(&self.standing),
            inputs,
            completion,
        };
        self.instance.request_by(
            ticket,
            service,
            asked,
            Box::new(move |step| match step {
                Progress::Accepted { activity } => {
                    progress(Heard::Accepted(tracked.started(activity)));
                }
                Progress::Ended(outcome) => {
                    let refused = tracked.completed();
                    tracked.ended(Outcome::from(&outcome));
                    progress(refused.map_or(Heard::Ended(outcome), Heard::Refused));
                }
            }),
        );
    }

    /// Whether the calling thread may wait for the outcome of a service.
    ///
    /// # Errors
    /// It is the thread that would have to execute the service.
    pub fn may_wait_here(&self, service: ServiceIx) -> Result<(), CannotWait> {
        self.instance.may_wait_here(service)
    }

    /// Reports the states of an activity to `follower`. To be called while `Heard::Accepted` is
    /// handled, so that no state is missed.
    pub fn follow(&self, activity: &Activity, follower: Follower) {
        if let Ok(number) = u32::try_from(activity.number) {
            self.watcher.follow(number, follower);
        }
    }

    /// Whether the inputs of a service are remembered for dumps.
    fn remembered(&self, service: ServiceIx) -> bool {
        let service = &self.model().services[service];
        let takes = service.parameters.iter().any(|one| one.direction != Direction::Out);
        !service.standard
            && match service.kind {
                ServiceKind::Attribute => takes,
                ServiceKind::Activity => true,
                ServiceKind::Function => false,
            }
    }

    /// Asks an activity to stop. Returns `false` if it is unknown or has ended.
    pub fn abort(&self, number: u64) -> bool {
        u32::try_from(number).is_ok_and(|number| self.instance.abort(number).is_ok())
    }

    /// Asks all activities to stop. Returns the numbers and services of those that had not ended.
    pub fn abort_all(&self) -> Vec<(u64, String)> {
        let told = self.instance.abort_all().into_iter();
        let services = &self.model().services;
        told.map(|(id, service)| (u64::from(id), services[service].name.clone())).collect()
    }

    /// Fires an external event, given by the index of its sink.
    pub fn fire(&self, sink: usize) {
        if let Err(error) = self.instance.fire(sink) {
            tracing::warn!(instance = self.name, "{error}");
        }
    }

    /// The state of an activity, or `waiting` before it starts.
    pub fn state(&self, number: u64) -> Option<String> {
        let activities = self.instance.activities();
        let found = activities.into_iter().find(|info| u64::from(info.id) == number)?;
        if found.phase == ActivityPhase::Init {
            return Some("waiting".to_owned());
        }
        // A task runs one codel at a time: a stuck codel of this service belongs to this activity,
        // unless another activity of the same service is running.
        let mut stuck = self.stuck().into_iter();
        let own = |codel: &RunningCodel| {
            codel.task.as_ref() == Some(&found.task) && Some(&codel.owner) == found.service.as_ref()
        };
        let stuck = stuck.find(own).filter(|_| !found.paused);
        Some(stuck.as_ref().map_or(found.state, stuck_in))
    }

    /// Whether its tasks wait until they are told to go on.
    pub fn is_held(&self) -> bool {
        self.instance.is_held()
    }

    /// Lets its tasks go on.
    pub fn go_on(&self) {
        self.instance.go_on();
    }

    /// Where its codels wrote past the memory they were given, if that was detected.
    pub fn damage(&self) -> Option<String> {
        self.instance.damage()
    }

    /// Statistics of its tasks and codels.
    pub fn figures(&self) -> Statistics {
        self.instance.statistics()
    }

    /// How often its tasks took how long, since the start.
    pub fn histograms(&self) -> Vec<TaskHistograms> {
        self.instance.histograms()
    }

    /// Connects an in port, or disconnects it, with all codels excluded (genom3.md 7.8).
    pub fn bind_in(
        &self,
        key: &PortKey,
        subscription: Option<Box<dyn Subscription>>,
    ) -> Result<(), HeldUp> {
        let PortKey { port, element } = key;
        self.instance.exclusively(|body| body.bind_in(*port, element.as_deref(), subscription))
    }

    /// Binds an out port with all codels excluded.
    pub fn bind_out(&self, key: &PortKey, publisher: Box<dyn Publisher>) -> Result<(), HeldUp> {
        let PortKey { port, element } = key;
        self.instance.exclusively(|body| body.bind_out(*port, element.as_deref(), Some(publisher)))
    }

    /// Calls `work` while no codel that uses a port is running.
    pub fn excluded<R>(&self, work: impl FnOnce() -> R) -> Result<R, HeldUp> {
        self.instance.exclusively(|_| work())
    }

    /// Connects a remote, or disconnects it, with all codels excluded.
    pub fn bind_remote(
        &self,
        remote: RemoteIx,
        call: Option<Box<dyn RemoteCall>>,
    ) -> Result<(), HeldUp> {
        self.instance.exclusively(|body| body.bind_remote(remote, call))
    }

    /// Its codels that count as stuck.
    pub fn stuck(&self) -> Vec<RunningCodel> {
        let mut all = self.instance.running_codels();
        all.retain(|codel| codel.stuck);
        all
    }

    /// Rounds of its control thread so far; `None` without one.
    pub fn control_rounds(&self) -> Option<u64> {
        self.instance.control_rounds()
    }

    /// Asks its control thread for another round.
    pub fn wake_control(&self) {
        self.instance.wake_control();
    }

    /// Checks for tasks that never pause; to be called several times a second.
    pub(crate) fn look_for_spins(&self) {
        let unpaused = self.instance.unpaused();
        self.spins_now().look(Instant::now(), unpaused, times_of);
    }

    /// Tasks that occupied a processor and never paused, as of the last check.
    pub fn spins(&self) -> Vec<Spin> {
        self.spins_now().found.clone()
    }

    fn spins_now(&self) -> MutexGuard<'_, Spins> {
        self.spins.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `stuck in CODEL for 12 s`, for the codel that has run longest.
    pub fn stuck_in(&self) -> Option<String> {
        self.instance.stuck().as_ref().map(stuck_in)
    }
}

/// Progress of a request.
#[derive(Debug)]
pub enum Heard {
    /// It is an activity, and was accepted.
    Accepted(Arc<Activity>),
    /// It ended.
    Ended(genom_runtime::Outcome),
    /// The inputs cannot be combined with the present values of the component. Nothing was changed.
    Refused(InputError),
}

/// How a codel that does not return is described to users.
fn stuck_in(codel: &RunningCodel) -> String {
    format!("stuck in {} for {}", codel.codel, seconds(codel.for_ns))
}
