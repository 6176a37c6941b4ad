//! Freezing an instance whose tasks run in threads (genom3.md 4.5, 7.10).

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use genom_description::model::{Owner, PortIx, RemoteIx};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, Frame, Opener, RemoteCall};
use genom_runtime::{Execution, Executor, FreezeError, Instance, Options, Resume};
use genom_types::{DataType, Record};
use serde_json::{Value, json};
use support::closures::{Closures, Codel, LONG, Nobody, codel, gate, next, request, until};

const PAIR: &str = "component pair {
    ids { long a; long b; };
    task t { period 1 ms; codel<start> t_start(inout a, inout b) yield pause::main;
             codel<main> t_step(inout a, inout b) yield pause::main; };
    task u { codel<start> u_start(inout a, inout b) yield pause::main;
             codel<main> u_step(inout a, inout b) yield pause::main; };
    function poke() { codel poke(inout a, inout b); };
};";

type Ids = Arc<[AtomicI64; 2]>;

/// A component with two numbers as its IDS.
struct Pair {
    codels: Arc<Closures>,
    ids: Ids,
}

/// Adds one to both numbers, one after the other.
fn adds(ids: &Ids) -> Codel {
    let ids = Arc::clone(ids);
    codel(move || {
        ids[0].fetch_add(1, Ordering::SeqCst);
        std::thread::yield_now();
        ids[1].fetch_add(1, Ordering::SeqCst);
        "pause::main"
    })
}

fn start(execution: Execution, resume: Option<Resume>) -> (Ids, Instance) {
    let ids = Ids::default();
    let add = adds(&ids);
    let poke = codel({
        let add = Arc::clone(&add);
        move || {
            add();
            "ok"
        }
    });
    let names = ["t_start", "t_step", "u_start", "u_step"];
    let mut codels: Vec<(&str, Codel)> = names.map(|name| (name, Arc::clone(&add))).into();
    codels.push(("poke", poke));
    let body = Pair { codels: Closures::new(PAIR, &codels), ids: Arc::clone(&ids) };
    let mut options = Options::new("pair", Arc::new(Nobody));
    options.execution = execution;
    options.resume = resume;
    (ids, Instance::start(Arc::clone(&body.codels.plan), Arc::new(body), options).unwrap())
}

impl Body for Pair {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        self.codels.frame(owner)
    }
    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}
    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }
    fn write_port(&self, _: PortIx, _: &Record) {}

    fn ids(&self) -> Option<Record> {
        let plan = &self.codels.plan;
        let ty = DataType::new(&plan.specification().types, plan.component().ids?).unwrap();
        let mut record = Record::new(&ty);
        let [a, b] = [0, 1].map(|at: usize| self.ids[at].load(Ordering::SeqCst));
        record.merge_json(&json!({"a": a, "b": b})).unwrap();
        Some(record)
    }

    fn set_ids(&self, ids: &Record) {
        let ids = ids.to_json();
        for (at, name) in ["a", "b"].into_iter().enumerate() {
            self.ids[at].store(ids[name].as_i64().unwrap(), Ordering::SeqCst);
        }
    }
}

/// Two tasks and requests write all the time, and no frozen IDS is what a codel left half done.
fn is_never_torn(execution: Execution) {
    let (_, instance) = start(execution, None);
    for round in 0..200 {
        let poke = request(&instance, "poke");
        let ids = instance.freeze(LONG, &mut || {}).unwrap().ids.unwrap().to_json();
        assert_eq!(ids["a"], ids["b"], "round {round}");
        assert_eq!(next(&poke), "done");
    }
}

#[test]
fn frozen_ids_are_those_between_two_codels() {
    is_never_torn(Execution::Threads);
}

#[test]
fn frozen_ids_are_those_between_two_codels_also_in_one_thread() {
    is_never_torn(Execution::Single(Arc::new(Executor::new("freezing"))));
}

#[test]
fn tasks_go_on_after_each_freeze() {
    let (ids, instance) = start(Execution::Threads, None);
    for _ in 0..20 {
        instance.freeze(LONG, &mut || {}).unwrap();
        let seen = ids[0].load(Ordering::SeqCst);
        until("the tasks go on", || ids[0].load(Ordering::SeqCst) > seen);
    }
}

#[test]
fn thawed_ids_replace_what_start_codels_wrote_before_any_other_codel_runs() {
    for execution in [Execution::Threads, Execution::Single(Arc::new(Executor::new("thawing")))] {
        let change = |ids: &mut Record| {
            // Each of the two tasks made one step, and no more.
            assert_eq!(ids.to_json(), json!({"a": 2, "b": 2}));
            ids.merge_json(&json!({"a": 1_000_000, "b": 1_000_000})).unwrap();
        };
        let resume = Resume {
            ids: Some(Box::new(change)),
            ports: Vec::new(),
            executed: Vec::new(),
            activities: Vec::new(),
            hold: false,
        };
        let (ids, _instance) = start(execution, Some(resume));
        until("the tasks go on", || ids[1].load(Ordering::SeqCst) > 1_000_001);
    }
}

#[test]
fn a_codel_that_runs_all_the_time_is_named() {
    let (gate, key) = gate();
    let text = "component c { ids { long x; }; task t { period 1 ms; };
        activity a() { task t; async codel<start> slow() yield ether; }; };";
    let slow = codel(move || {
        gate.pass();
        "ether"
    });
    let instance = Closures::new(text, &[("slow", slow)]).start();
    let answers = request(&instance, "a");
    key.wait();
    let refused = instance.freeze(Duration::ZERO, &mut || {}).unwrap_err();
    assert!(matches!(&refused, FreezeError::Busy(_)), "{refused}");
    assert!(refused.to_string().contains("slow"), "{refused}");
    key.let_one_pass();
    instance.freeze(LONG, &mut || {}).unwrap();
    assert_eq!(next(&answers), "accepted 2");
    assert_eq!(next(&answers), "done");
}
