//! The demo, its codels in C and in Rust, loaded and run by the runtime on a stepped clock.

#![allow(clippy::panic, clippy::unwrap_used)] // fakes and helpers are no test functions

mod support;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_host::{Component, Library};
use genom_middleware::{PublishError, Publisher};
use genom_runtime::body::Body;
use genom_runtime::{
    Clock, ConnectionError, Instance, Options, Outcome, Plan, Progress, Supervision, VirtualClock,
};
use genom_types::Record;
use serde_json::{Value, json};
use support::Scratch;

/// A supervisor that connects nothing.
struct Alone;

impl Supervision for Alone {
    fn connect_port(&self, local: &str, _: &str) -> Result<(), ConnectionError> {
        Err(ConnectionError::NoSuchInport(local.to_owned()))
    }
    fn connect_service(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Err(ConnectionError::PortIo("alone".to_owned()))
    }
    fn kill(&self) {}
}

/// Counts what is published.
struct Count(Arc<Mutex<usize>>);

impl Publisher for Count {
    fn publish(&mut self, _: &Record) -> Result<(), PublishError> {
        *self.0.lock().unwrap() += 1;
        Ok(())
    }
    fn dropped(&self) -> u64 {
        0
    }
}

/// A running demo.
struct Demo {
    instance: Instance,
    clock: Arc<VirtualClock>,
    published: Arc<Mutex<usize>>,
}

/// The outcome of a request, once it has ended.
type Ended = Arc<Mutex<Option<Outcome>>>;

impl Demo {
    fn start(library: &std::path::Path) -> Self {
        let text = include_str!("../../../components/demo/demo.gen");
        let analysis = genom_description::read_text("demo.gen", text, &Default::default());
        let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
        let library = Library::open(library).unwrap();
        let component = Component::load(library, &plan, &|_| "demo.gen".to_owned()).unwrap();
        let port = plan.component().ports.find(|port| port.name == "position").unwrap();
        let published = Arc::default();
        let count = Count(Arc::clone(&published));
        component.bind_out(port, None, Some(Box::new(count)));
        let clock = Arc::new(VirtualClock::new());
        let mut options = Options::new("demo", Arc::new(Alone));
        options.clock = Clock::Virtual(Arc::clone(&clock));
        let instance = Instance::start(plan, Arc::new(component), options).unwrap();
        Self { instance, clock, published }
    }

    fn request(&self, service: &str, input: &Value) -> Ended {
        let plan = self.instance.plan();
        let service = plan.service(service).unwrap();
        let mut record = Record::new(&plan.services()[service].input);
        record.merge_json(input).unwrap();
        let ended = Ended::default();
        let told = Arc::clone(&ended);
        let reply = move |progress| {
            if let Progress::Ended(outcome) = progress {
                *told.lock().unwrap() = Some(outcome);
            }
        };
        self.instance.request(service, record, Box::new(reply));
        ended
    }

    fn position(&self) -> f64 {
        let ended = self.request("get_position", &json!({}));
        let ended = ended.lock().unwrap();
        let Some(Outcome::Success(output)) = &*ended else { return f64::NAN };
        let mut members = output.to_json();
        members.as_object_mut().unwrap().values_mut().next().unwrap().as_f64().unwrap()
    }
}

/// The session that both demos have to pass.
fn story(library: &std::path::Path) {
    let demo = Demo::start(library);
    assert_eq!(*demo.published.lock().unwrap(), 1, "the start codel publishes");
    let far = demo.request("goto", &json!({ "goal": 1000.0 }));
    match &*far.lock().unwrap() {
        Some(Outcome::Exception(exception)) => {
            assert_eq!(exception.name, "::demo::OUT_OF_RANGE");
            assert_eq!(exception.detail["value"], json!(1000.0));
        }
        other => panic!("{other:?}"),
    }
    let fast = demo.request("set_speed", &json!({ "velocity": 2.0 }));
    assert!(matches!(&*fast.lock().unwrap(), Some(Outcome::Success(_))));

    let first = demo.request("goto", &json!({ "goal": 1.0 }));
    demo.clock.step(Duration::from_millis(200));
    assert!(first.lock().unwrap().is_none(), "on its way");
    let moved = demo.position();
    assert!(moved > 0.0 && moved < 1.0, "{moved}");
    let second = demo.request("goto", &json!({ "goal": -0.5 }));
    demo.clock.step(Duration::from_secs(5));
    assert!(matches!(&*first.lock().unwrap(), Some(Outcome::Success(_))), "stopped smoothly");
    assert!(matches!(&*second.lock().unwrap(), Some(Outcome::Success(_))));
    assert_eq!(demo.position(), -0.5);
    assert!(*demo.published.lock().unwrap() > 50);
    let port = demo.instance.plan().component().ports.find(|p| p.name == "position");
    let shown = demo.instance.port_value(port.unwrap(), None).unwrap();
    assert_eq!(shown["position"], json!(-0.5));

    let halted = demo.request("goto", &json!({ "goal": 5.0 }));
    demo.clock.step(Duration::from_millis(100));
    demo.instance.fire(0).unwrap();
    demo.clock.step(Duration::from_millis(100));
    match &*halted.lock().unwrap() {
        Some(Outcome::Exception(exception)) => assert_eq!(exception.name, "::demo::HALTED"),
        other => panic!("{other:?}"),
    }
    demo.instance.shutdown(Duration::from_secs(10)).unwrap();
}

#[test]
fn the_demo_in_c_moves_stops_and_halts() {
    let scratch = Scratch::new();
    story(&support::demo::in_c(&scratch, &[]));
}

#[test]
fn the_demo_in_rust_does_the_same() {
    story(&support::demo::in_rust());
}
