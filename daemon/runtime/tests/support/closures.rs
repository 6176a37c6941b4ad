//! A body whose codels are closures, for tests with real threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use genom_description::model::{CodelIx, Indexed, Ix as _, Owner, PortIx, RemoteIx, ServiceIx};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, EventId, Frame, Opener, RemoteCall, Returned};
use genom_runtime::{
    ConnectionError, Instance, Options, Outcome, Plan, Progress, StartError, Supervision,
    input_record,
};
use genom_types::Record;
use serde_json::{Value, json};

/// Timeout for what must happen.
pub(crate) const LONG: Duration = Duration::from_secs(30);

/// Code of a codel; returns an event without scope, or `ok`.
pub(crate) type Codel = Arc<dyn Fn() -> &'static str + Send + Sync>;

/// A closure as a codel.
pub(crate) fn codel(work: impl Fn() -> &'static str + Send + Sync + 'static) -> Codel {
    Arc::new(work)
}

/// A component whose codels are Rust closures.
pub(crate) struct Closures {
    pub(crate) plan: Arc<Plan>,
    /// The closure of each codel of the model.
    codels: Indexed<CodelIx, Option<Codel>>,
    events: Vec<(&'static str, EventId)>,
    /// Number of values that codels wrote on any port, if they count them.
    pub(crate) written: OnceLock<Arc<AtomicU64>>,
    /// Number of writes to the state port.
    pub(crate) states: AtomicU64,
}

impl Closures {
    pub(crate) fn new(gen_text: &str, codels: &[(&str, Codel)]) -> Arc<Self> {
        let plan = super::plan(gen_text);
        let find = |name: &str| codels.iter().find(|(codel, _)| *codel == name);
        let codels =
            plan.component().codels.iter().map(|c| find(&c.name).map(|c| Arc::clone(&c.1)));
        let codels = codels.collect();
        let scope = plan.component().scope();
        let names =
            ["start", "stop", "ether", "main", "pause::main", "pause::start", "pause::stop", "E"];
        let events = names
            .iter()
            .filter_map(|name| plan.event(&format!("{scope}::{name}")).map(|event| (*name, event)));
        let events = events.collect();
        let (written, states) = (OnceLock::new(), AtomicU64::new(0));
        Arc::new(Self { plan, codels, events, written, states })
    }

    pub(crate) fn start(self: &Arc<Self>) -> Instance {
        self.start_with(|_| {})
    }

    pub(crate) fn try_start(self: &Arc<Self>) -> Result<Instance, StartError> {
        self.try_start_with(options())
    }

    #[track_caller]
    pub(crate) fn start_with(self: &Arc<Self>, change: impl FnOnce(&mut Options)) -> Instance {
        self.try_start_with_options(change).unwrap()
    }

    pub(crate) fn try_start_with_options(
        self: &Arc<Self>,
        change: impl FnOnce(&mut Options),
    ) -> Result<Instance, StartError> {
        let mut options = options();
        change(&mut options);
        self.try_start_with(options)
    }

    fn try_start_with(self: &Arc<Self>, options: Options) -> Result<Instance, StartError> {
        let body: Arc<dyn Body> = Arc::<Self>::clone(self);
        Instance::start(Arc::clone(&self.plan), body, options)
    }
}

fn options() -> Options {
    let mut options = Options::new("test", Arc::new(Nobody));
    options.execution = super::execution();
    options
}

/// Waits until a condition holds.
#[track_caller]
pub(crate) fn until(what: &str, so: impl Fn() -> bool) {
    let end = Instant::now() + LONG;
    while !so() {
        assert!(Instant::now() < end, "{what}: this does not come to be");
        std::thread::yield_now();
    }
}

/// Requests a service; its progress comes through the channel.
#[track_caller]
pub(crate) fn request(instance: &Instance, service: &str) -> Receiver<String> {
    let plan = instance.plan();
    let rank = plan.service(service).unwrap();
    let (sender, receiver) = channel();
    let reply = Box::new(move |progress| {
        let _ = sender.send(match progress {
            Progress::Accepted { activity } => format!("accepted {activity}"),
            Progress::Ended(Outcome::Success(_)) => "done".into(),
            Progress::Ended(Outcome::Exception(exception)) => exception.to_string(),
        });
    });
    instance.request(rank, input_record(plan, rank).unwrap().unwrap(), reply);
    receiver
}

/// The next message of a request.
#[track_caller]
pub(crate) fn next(receiver: &Receiver<String>) -> String {
    receiver.recv_timeout(LONG).expect("an answer in time")
}

impl Body for Closures {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        let service = match owner {
            Owner::Service(service) => &self.plan.services()[service],
            Owner::Task(_) => &self.plan.services()[ServiceIx::new(0)],
        };
        Box::new(ClosureFrame {
            codels: self.codels.clone(),
            events: self.events.clone(),
            output: Record::new(&service.output),
        })
    }

    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}

    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }

    fn written(&self, _: PortIx) -> u64 {
        self.written.get().map_or(0, |written| written.load(Ordering::SeqCst))
    }

    fn write_port(&self, _: PortIx, _: &Record) {
        self.states.fetch_add(1, Ordering::SeqCst);
    }
}

struct ClosureFrame {
    codels: Indexed<CodelIx, Option<Codel>>,
    events: Vec<(&'static str, EventId)>,
    output: Record,
}

impl Frame for ClosureFrame {
    fn begin(&mut self, _: &Record) {}
    fn store(&mut self) {}
    fn fetch(&mut self) {}

    fn call(&mut self, codel: CodelIx, _: usize) -> Returned {
        let event = self.codels[codel].as_ref().map_or("ok", |codel| codel());
        if event == "ok" {
            return Returned::Ok;
        }
        let found = self.events.iter().find(|(name, _)| *name == event);
        found.map_or(Returned::Unknown, |(_, event)| Returned::Event(*event))
    }

    fn returned(&self) -> String {
        "::unknown".into()
    }

    fn detail(&self) -> Option<Value> {
        Some(json!({ "code": 1 }))
    }

    fn output(&self) -> &Record {
        &self.output
    }
}

/// A supervisor that does nothing.
pub(crate) struct Nobody;

impl Supervision for Nobody {
    fn connect_port(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }

    fn connect_service(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }

    fn kill(&self) {}
}

/// A gate that codels wait at; `arrivals` receives a message for each.
pub(crate) struct Gate {
    open: Mutex<Receiver<()>>,
    arrivals: Mutex<std::sync::mpsc::Sender<()>>,
}

/// The other side of a gate.
pub(crate) struct Keeper {
    pub(crate) open: std::sync::mpsc::Sender<()>,
    pub(crate) arrivals: Receiver<()>,
}

pub(crate) fn gate() -> (Gate, Keeper) {
    let (open, opened) = channel();
    let (arrive, arrivals) = channel();
    (Gate { open: Mutex::new(opened), arrivals: Mutex::new(arrive) }, Keeper { open, arrivals })
}

impl Gate {
    /// Waits until the keeper opens the gate, or is dropped.
    pub(crate) fn pass(&self) {
        let _ = self.arrivals.lock().unwrap().send(());
        let _ = self.open.lock().unwrap().recv();
    }
}

impl Keeper {
    /// Waits until a codel has arrived at the gate.
    #[track_caller]
    pub(crate) fn wait(&self) {
        self.arrivals.recv_timeout(LONG).expect("somebody at the gate in time");
    }

    pub(crate) fn let_one_pass(&self) {
        self.open.send(()).unwrap();
    }
}
