//! Values of `genom_state` over time, on a virtual clock.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _, Owner, PortIx, RemoteIx, ServiceIx, TaskIx};
use genom_description::{Options, read_text};
use genom_middleware::{Publisher, Subscription};
use genom_types::Record;
use serde_json::{Value, json};

use crate::body::{Body, Frame, Opener, RemoteCall, Returned};
use crate::engine::Engine;
use crate::{Clock, ConnectionError, Plan, Supervision, VirtualClock};

/// Keeps the last value of the state port.
struct Kept {
    plan: Arc<Plan>,
    last: Mutex<Option<Value>>,
}

impl Body for Kept {
    fn frame(&self, _: Owner) -> Box<dyn Frame> {
        Box::new(Empty(Record::new(&self.plan.services()[ServiceIx::new(0)].output)))
    }
    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}
    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }
    fn write_port(&self, _: PortIx, value: &Record) {
        *self.last.lock().unwrap() = Some(value.to_json());
    }
}

/// The frame of tasks without codels.
struct Empty(Record);

impl Frame for Empty {
    fn begin(&mut self, _: &Record) {}
    fn store(&mut self) {}
    fn fetch(&mut self) {}
    fn call(&mut self, _: CodelIx, _: usize) -> Returned {
        Returned::Ok
    }
    fn returned(&self) -> String {
        String::new()
    }
    fn detail(&self) -> Option<Value> {
        None
    }
    fn output(&self) -> &Record {
        &self.0
    }
}

struct Nobody;

impl Supervision for Nobody {
    fn connect_port(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }
    fn connect_service(&self, _: &str, _: &str) -> Result<(), ConnectionError> {
        Ok(())
    }
    fn kill(&self) {}
}

/// An instance of one task, and its clock.
struct World {
    clock: Arc<VirtualClock>,
    body: Arc<Kept>,
    engine: Arc<Engine>,
}

impl World {
    fn new(task: &str) -> Self {
        let text = format!("component c {{ version \"1.2\"; task t {{ {task} }}; }};");
        let analysis = read_text("c.gen", &text, &Options::default());
        assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
        let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
        let body = Arc::new(Kept { plan: Arc::clone(&plan), last: Mutex::default() });
        let clock = Arc::new(VirtualClock::new());
        let mut options = crate::Options::new("c", Arc::new(Nobody));
        options.clock = Clock::Virtual(Arc::clone(&clock));
        options.date = "2026-11-21T12:00:00Z".to_owned();
        let engine = Engine::start(&plan, Arc::<Kept>::clone(&body), options).unwrap();
        Self { clock, body, engine }
    }

    /// Simulates seconds with ten cycles each, all of duration `work`.
    fn live(&self, seconds: usize, work: Duration) {
        let nanos = u64::try_from(work.as_nanos()).unwrap();
        for _ in 0..seconds {
            (0..10).for_each(|_| lasted(&self.engine.shared.tasks[TaskIx::new(0)], nanos));
            self.clock.step(Duration::from_secs(1));
        }
    }

    fn state(&self) -> Value {
        self.body.last.lock().unwrap().clone().expect("the port is written at the start")
    }

    /// Checks average and maximum of a figure of the task.
    #[track_caller]
    fn expect(&self, figure: &str, average: f64, max: f64) {
        let state = self.state();
        let found = &state["task"][0]["rusage"][figure];
        // The port carries 32-bit floats.
        let near = |key: &str, wanted: f64| {
            let found = found[key].as_f64().unwrap();
            (found - wanted).abs() <= wanted * 1e-5
        };
        assert!(near("avg", average) && near("max", max), "{figure}: {found}");
    }
}

/// Records a cycle of this duration.
fn lasted(task: &crate::shared::TaskShared, ns: u64) {
    task.figures.cycles.begins(0);
    task.figures.cycles.ends(ns);
}

#[test]
fn the_state_port_tells_what_the_component_is() {
    // genom3.md 4.8: digest, date and version.
    let world = World::new("");
    let state = world.state();
    assert_eq!(state["date"], json!("2026-11-21T12:00:00Z"));
    assert_eq!(state["version"], json!("1.2"));
    assert_eq!(state["digest"], json!(world.engine.shared.plan.component().digest));
}

#[test]
fn averages_of_the_state_port_are_those_of_about_the_last_ten_seconds() {
    // genom3.md 4.8, 7.8.
    let world = World::new("");
    world.live(60, Duration::from_millis(50));
    world.expect("timings", 0.05, 0.05);
    world.expect("load", 50.0, 50.0);
    // The average forgets the past minute after ten seconds; the maximum keeps it.
    world.live(10, Duration::from_millis(10));
    world.expect("timings", 0.01, 0.05);
    world.expect("load", 10.0, 50.0);
    // Of a task that does nothing any more, only the maximum remains.
    world.clock.step(Duration::from_secs(11));
    world.expect("timings", 0.0, 0.05);
    world.expect("load", 0.0, 50.0);
}

#[test]
fn the_load_of_a_periodic_task_is_that_of_its_period() {
    let world = World::new("period 100 ms;");
    (0..10).for_each(|_| lasted(&world.engine.shared.tasks[TaskIx::new(0)], 150_000_000));
    world.clock.step(Duration::from_secs(1));
    let load = world.state()["task"][0]["rusage"]["load"]["max"].as_f64().unwrap();
    assert!((load - 150.0).abs() < 0.01, "an overrun shows: {load}");
}
