//! The rules of a task, tested without a thread: which pass runs which codel.

use std::sync::Arc;

use genom_description::model::{CodelIx, Ix as _, Owner, ServiceIx};
use genom_description::{Options, read_text};
use genom_types::Record;
use serde_json::Value;

use super::core::{Calls, Core, Passed};
use super::run::{Marker, Run, RunOutcome, Status, Token};
use crate::body::{EventId, Frame, Returned};
use crate::plan::Plan;

struct NoFrame(Record);

impl Frame for NoFrame {
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

/// Codels that return the state of a given name; calls are recorded.
struct Names<'a> {
    plan: &'a Plan,
    called: Vec<&'a str>,
    returns: &'a [(&'a str, &'a str)],
}

impl Calls for Names<'_> {
    fn call(&mut self, _: &mut Run, codel: CodelIx) -> Returned {
        let name = self.plan.component().codels[codel].name.as_str();
        let (codel, event) = self.returns.iter().find(|(codel, _)| *codel == name).unwrap();
        self.called.push(codel);
        let rank = self.plan.event(&format!("::c::{event}")).unwrap_or(EventId(u16::MAX));
        Returned::Event(rank)
    }
    fn moved(&mut self, _: &Run, _: Token) {}
}

fn plan() -> Plan {
    let text = "component c {
        task t { period 5 ms; };
        activity a() { task t; codel<start> s() yield main; codel<main> m() yield main, pause::main;
                       codel<stop> e() yield ether; };
    };";
    let analysis = read_text("c.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    Plan::new(&Arc::new(analysis.specification), 0).unwrap()
}

fn run(plan: &Plan) -> (Box<Run>, Arc<Marker>) {
    let owner = Owner::Service(plan.service("a").unwrap());
    let machine = plan.machines().iter().position(|machine| machine.owner == owner).unwrap();
    let marker = Arc::new(Marker::new(plan.machines()[machine].start));
    let frame = Box::new(NoFrame(Record::new(&plan.services()[ServiceIx::new(0)].output)));
    let tokens = Vec::with_capacity(8);
    let shared = Arc::clone(&marker);
    (Box::new(Run { id: 1, machine, frame, marker, tokens, at_stop: false, outcome: None }), shared)
}

const LOOPS: &[(&str, &str)] = &[("s", "main"), ("m", "main"), ("e", "ether")];

#[test]
fn a_new_activity_starts_on_a_tick_only() {
    // genom3.md 7.4, periodic tasks.
    let plan = plan();
    let mut core = Core::new(4, false);
    let (run, marker) = run(&plan);
    core.admit(run);
    let mut names = Names { plan: &plan, called: Vec::new(), returns: LOOPS };
    assert_eq!(core.pass(&plan, false, &[], &mut names), Passed::default());
    assert_eq!((names.called.len(), marker.status()), (0, Status::Init));
    assert_eq!(core.pass(&plan, true, &[], &mut names), Passed { again: true, moved: true });
    assert_eq!((names.called, marker.status()), (vec!["s"], Status::Run));
}

#[test]
fn a_stop_request_is_looked_at_on_every_pass() {
    // genom3.md 7.4, 7.5: also between ticks; the last state yielded is dropped.
    let plan = plan();
    let mut core = Core::new(4, false);
    let (run, marker) = run(&plan);
    core.admit(run);
    let mut names = Names { plan: &plan, called: Vec::new(), returns: LOOPS };
    core.pass(&plan, true, &[], &mut names);
    core.pass(&plan, false, &[], &mut names);
    marker.request_stop();
    let passed = core.pass(&plan, false, &[], &mut names);
    assert_eq!(passed, Passed { again: false, moved: true });
    assert_eq!(names.called, ["s", "m", "e"]);
    let mut ends = Vec::new();
    core.take_ended(|run| ends.push(run.outcome));
    assert_eq!(ends, [Some(RunOutcome::Success)]);
    assert!(core.is_empty());
}

#[test]
fn a_paused_activity_resumes_on_a_tick_only() {
    // genom3.md 7.4, periodic tasks.
    let plan = plan();
    let mut core = Core::new(4, false);
    core.admit(run(&plan).0);
    let returns = [("s", "main"), ("m", "pause::main")];
    let mut names = Names { plan: &plan, called: Vec::new(), returns: &returns };
    core.pass(&plan, true, &[], &mut names);
    assert!(!core.pass(&plan, false, &[], &mut names).again);
    core.pass(&plan, false, &[], &mut names);
    core.pass(&plan, false, &[], &mut names);
    assert_eq!(names.called, ["s", "m"]);
    core.pass(&plan, true, &[], &mut names);
    assert_eq!(names.called, ["s", "m", "m"]);
}
