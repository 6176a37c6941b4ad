//! Calling a codel allocates nothing: neither for arguments, nor for ports, nor for the event.

#![allow(clippy::unwrap_used)] // in fakes

mod support;

use genom_allocations as allocations;
use genom_description::model::Owner;
use genom_host::{Component, Library};
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_runtime::Plan;
use genom_runtime::body::{Body, Returned};
use genom_types::Record;
use support::Scratch;

/// Counts how often it is called.
struct Sink(std::sync::Arc<std::sync::atomic::AtomicUsize>);

impl Publisher for Sink {
    fn publish(&mut self, _: &Record) -> Result<(), PublishError> {
        self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(())
    }
    fn dropped(&self) -> u64 {
        0
    }
}

/// Has a new value at each read.
struct Source;

impl Subscription for Source {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        into.set_bytes(&2.5_f64.to_ne_bytes()).unwrap();
        Ok(Reading::New)
    }
    fn dropped(&self) -> u64 {
        0
    }
}

const GEN: &str = "component demo {
    struct state { double position; double velocity; };
    exception TOO_FAR { double limit; };
    ids { double velocity; sequence<state> many; };
    typedef double gain;
    port in gain parameter;
    port out state position;
    task main { period 5 ms; };
    activity move(in double goal, out double reached) {
        task main;
        codel<start> fill(out many) yield servo;
        codel<servo> servo(in goal, inout many[1].position::p, out reached, in parameter,
                           out position) yield pause::servo, ether;
        throw TOO_FAR;
    };
};";

const C: &str = r#"
#include <stdint.h>
#include <genom3/c/idlsequence.h>
#include <genom3/c/exception.h>
GENOM_EVENT(demo_servo_, "::demo::servo");
GENOM_EVENT(demo_pause_servo, "::demo::pause::servo");
GENOM_EVENT(demo_TOO_FAR_id, "::demo::TOO_FAR");
typedef struct demo_TOO_FAR_detail { double limit; } demo_TOO_FAR_detail;
typedef struct demo_state { double position, velocity; } demo_state;
typedef struct sequence_demo_state { uint32_t _maximum, _length; demo_state *_buffer;
  void (*_release)(void *); } sequence_demo_state;
typedef struct demo_parameter { double *(*data)(genom_context self);
  genom_event (*read)(genom_context self); } demo_parameter;
typedef struct demo_position { demo_state *(*data)(genom_context self);
  genom_event (*write)(genom_context self); } demo_position;

genom_event fill(sequence_demo_state *many, const genom_context self) {
  if (genom_sequence_reserve(many, 2)) return genom_fatal;
  many->_length = 2;
  return demo_servo_;
}
genom_event servo(double goal, double *p, double *reached, const demo_parameter *parameter,
                  const demo_position *position, const genom_context self) {
  genom_event e = parameter->read(self);
  if (e) return e;
  *p += *parameter->data(self);
  *reached = *p;
  position->data(self)->position = *p;
  e = position->write(self);
  if (e) return e;
  if (*p > goal) {
    demo_TOO_FAR_detail d = { goal };
    return self->raise(demo_TOO_FAR_id, &d, sizeof d, self);
  }
  return demo_pause_servo;
}
"#;

#[test]
fn ten_thousand_codels_with_ports_and_an_exception_allocate_nothing() {
    let scratch = Scratch::new();
    let library = Library::open(&scratch.library("demo.so", C)).unwrap();
    let analysis = genom_description::read_text("demo.gen", GEN, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let plan = Plan::new(&std::sync::Arc::new(analysis.specification), 0).unwrap();
    let component = Component::load(library, &plan, &|_| "demo.gen".to_owned())
        .unwrap_or_else(|errors| panic!("{errors}"));
    let port = |name| plan.component().ports.find(|port| port.name == name).unwrap();
    let written = std::sync::Arc::default();
    let sink = Sink(std::sync::Arc::clone(&written));
    component.bind_out(port("position"), None, Some(Box::new(sink)));
    component.bind_in(port("parameter"), None, Some(Box::new(Source)));
    let service = plan.service("move").unwrap();
    let [fill, servo] = plan.component().services[service].codels[..] else { panic!("two codels") };
    let mut frame = component.frame(Owner::Service(service));
    let mut input = Record::new(&plan.services()[service].input);
    input.merge_json(&serde_json::json!({ "goal": 25_000 })).unwrap();
    frame.begin(&input);
    let event = |name| Returned::Event(plan.event(name).unwrap());
    assert_eq!(frame.call(fill, 0), event("::demo::servo"));
    assert_eq!(frame.call(servo, 0), event("::demo::pause::servo"));

    let before = allocations::count();
    let mut last = Returned::Ok;
    for _ in 0..10_000 {
        last = frame.call(servo, 0);
    }
    let allocated = allocations::count() - before;

    assert_eq!(allocated, 0);
    assert_eq!(last, event("::demo::TOO_FAR"));
    assert_eq!(frame.detail(), Some(serde_json::json!({ "limit": 25_000.0 })));
    assert_eq!(written.load(std::sync::atomic::Ordering::Relaxed), 10_001);
    assert_eq!(frame.output().to_json(), serde_json::json!({ "reached": 25_002.5 }));
    let seen = component.port_value(port("position"), None);
    assert_eq!(seen, Some(serde_json::json!({ "position": 25_002.5, "velocity": 0.0 })));
}
