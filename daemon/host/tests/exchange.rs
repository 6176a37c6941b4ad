//! The code of a component is exchanged while its memory stays.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod support;

use std::sync::Arc;
use std::time::Duration;

use genom_description::{Options as Reading, read_text};
use genom_host::{CannotExchange, Component, Library};
use genom_runtime::body::Body;
use genom_runtime::plan::Plan;
use genom_runtime::{
    Clock, ConnectionError, Inputs, Instance, Options, Outcome, Progress, Supervision, Ticket,
    VirtualClock,
};
use genom_types::Record;
use serde_json::{Value, json};
use support::Scratch;

const GEN: &str = "component c {
    exception E { long code; };
    ids { long n; string text; };
    task t { period 1 ms; codel<start> c_start(out ::ids) yield main;
             codel<main> c_step(inout n) yield pause::main; };
    function get(out long seen) { codel c_get(in n, out seen); throw E; };
    attribute set_text(in text);
    attribute get_text(out text);
};";

/// Codels that count by `STEP`, and throw what they are compiled with.
const C: &str = r#"
#include <stddef.h>
#include <stdint.h>
typedef const char *genom_event;
struct ids { int32_t n; char *text; };
genom_event c_start(struct ids *ids, void *self) { (void)self; ids->n = 0; return "::c::main"; }
genom_event c_step(int32_t *n, void *self) { (void)self; *n += STEP; return "::c::pause::main"; }
genom_event c_get(int32_t n, int32_t *seen, void *self) { (void)self; *seen = n; return NULL; }
"#;

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

fn plan(text: &str) -> Arc<Plan> {
    let analysis = read_text("c.gen", text, &Reading::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap())
}

fn load(scratch: &Scratch, plan: &Plan, name: &str, step: i32) -> Component {
    let step = format!("-DSTEP={step}");
    let path = scratch.cc(name, C, &["-shared", "-fPIC", "-g0", &step]);
    let locate = |_| "c.gen:1".to_owned();
    Component::load(Library::open(&path).unwrap(), plan, &locate).unwrap_or_else(|e| panic!("{e}"))
}

fn call(instance: &Instance, service: &str, inputs: Value) -> Value {
    let rank = instance.plan().service(service).unwrap();
    let mut input = Record::new(&instance.plan().services()[rank].input);
    input.merge_json(&inputs).unwrap();
    let (sender, ended) = std::sync::mpsc::channel();
    let reply = Box::new(move |progress| {
        if let Progress::Ended(outcome) = progress {
            let _ = sender.send(outcome);
        }
    });
    instance.request_by(&Ticket::default(), rank, Inputs::Whole(input), reply);
    match ended.recv().unwrap() {
        Outcome::Success(output) => output.to_json(),
        Outcome::Exception(exception) => json!(exception.to_string()),
    }
}

#[test]
fn codels_of_another_library_go_on_with_the_memory_of_the_first() {
    let (scratch, plan) = (Scratch::new(), plan(GEN));
    let component = Arc::new(load(&scratch, &plan, "one.so", 1));
    let clock = Arc::new(VirtualClock::new());
    let mut options = Options::new("c", Arc::new(Nobody));
    options.clock = Clock::Virtual(Arc::clone(&clock));
    let body: Arc<dyn Body> = Arc::clone(&component) as _;
    let instance = Instance::start(Arc::clone(&plan), body, options).unwrap();
    clock.step(Duration::from_millis(10));
    call(&instance, "set_text", json!({ "text": "as it was" }));
    let first = call(&instance, "get", json!({}))["seen"].as_i64().unwrap();
    let limit = Duration::from_secs(30);
    let mut expected = first;
    // Libraries come to lie where others were: nothing that is remembered of one is used of the
    // next.
    for step in 2..12 {
        let new = load(&scratch, &plan, &format!("{}.so", step % 3), step);
        instance.at_rest(limit, |rest| component.exchange(&new, rest)).unwrap().unwrap();
        assert!(component.library().ends_with(format!("{}.so", step % 3)));
        assert!(new.library().ends_with("one.so") || step > 2);
        drop(new);
        clock.step(Duration::from_millis(10));
        expected += i64::from(step) * 10;
        assert_eq!(call(&instance, "get", json!({})), json!({ "seen": expected }));
    }
    assert_eq!(call(&instance, "get_text", json!({})), json!({ "text": "as it was" }));
    instance.shutdown(limit).unwrap();
}

#[test]
fn what_does_not_rest_or_is_of_another_description_is_not_exchanged() {
    let (scratch, first) = (Scratch::new(), plan(GEN));
    let (one, two) = (load(&scratch, &first, "one.so", 1), load(&scratch, &first, "two.so", 2));
    let one = Arc::new(one);
    let clock = Arc::new(VirtualClock::new());
    let mut options = Options::new("c", Arc::new(Nobody));
    options.clock = Clock::Virtual(Arc::clone(&clock));
    let body: Arc<dyn Body> = Arc::clone(&one) as _;
    let instance = Instance::start(Arc::clone(&first), body, options).unwrap();
    clock.step(Duration::from_millis(1));
    let limit = Duration::from_secs(30);
    let refused = instance.at_rest(limit, |rest| two.exchange(&one, rest)).unwrap();
    assert_eq!(refused, Err(CannotExchange::NotAtRest));
    let longer = plan(
        &GEN.replace("ids { long n; string text; }", "ids { long n; string text; long more; }"),
    );
    let three = load(&scratch, &longer, "three.so", 3);
    let refused = instance.at_rest(limit, |rest| one.exchange(&three, rest)).unwrap();
    assert_eq!(refused, Err(CannotExchange::Unlike));
    instance.shutdown(limit).unwrap();
}
