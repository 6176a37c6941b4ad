//! Ports, exceptions and attributes of codels in C++.

use std::sync::{Arc, Mutex};

use genom_description::model::PortIx;
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_runtime::body::{Body, ElementError, Opener};
use genom_types::Record;
use serde_json::{Value, json};

use crate::axis::{AXIS, axis};
use crate::support::cxx::load;

/// What was published, as JSON.
type Sent = Arc<Mutex<Vec<Value>>>;

struct FakePublisher(Sent);

impl Publisher for FakePublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.0.lock().unwrap().push(value.to_json());
        Ok(())
    }
    fn dropped(&self) -> u64 {
        0
    }
}

/// Returns these values, then the last one again.
struct FakeSubscription(Vec<Value>);

impl Subscription for FakeSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        match self.0.pop() {
            Some(value) => {
                into.merge_json(&value).unwrap();
                Ok(Reading::New)
            }
            None => Ok(Reading::Never),
        }
    }
    fn dropped(&self) -> u64 {
        0
    }
}

struct FakeOpener(Sent);

impl Opener for FakeOpener {
    fn open(&self, _: PortIx, _: &str) -> Result<Box<dyn Publisher>, ElementError> {
        Ok(Box::new(FakePublisher(Arc::clone(&self.0))))
    }

    fn close(&self, _: PortIx, _: &str) {}
}

#[test]
fn ports_are_read_and_written_and_what_fails_is_thrown() {
    let demo = load(&axis(), AXIS);
    assert_eq!(demo.task("t_start"), "::demo::ether");
    let (input, output) = (demo.port("input"), demo.port("output"));
    let sent = Sent::default();
    let mut frame = demo.begin("move", json!({ "to": 1.0 }));
    // Not connected: `read` throws, and the codel does not catch.
    assert_eq!(demo.call(&mut *frame, "m_main"), "::genom::no_such_inport");

    demo.component.bind_out(output, None, Some(Box::new(FakePublisher(Arc::clone(&sent)))));
    demo.component.bind_in(input, None, Some(Box::new(FakeSubscription(vec![]))));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::demo::pause::main");
    assert_eq!(frame.output().to_json(), json!({ "seen": "::genom::no_such_inport" }));
    assert_eq!(*sent.lock().unwrap(), [json!({ "frame": "none", "values": [] })]);

    let value = json!({ "frame": "base", "values": [1.5, 2.5] });
    let subscription = FakeSubscription(vec![value]);
    demo.component.bind_in(input, None, Some(Box::new(subscription)));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::demo::ether");
    assert_eq!(frame.output().to_json(), json!({ "seen": "none" }), "a buffer keeps its value");
    let published = json!({ "frame": "base", "values": [1.5, 2.5, 8.0] });
    assert_eq!(sent.lock().unwrap().last(), Some(&published));
    assert_eq!(demo.component.port_value(output, None), Some(published));
}

#[test]
fn elements_of_multiple_ports_are_opened_and_closed_by_name() {
    let demo = load(&axis(), AXIS);
    let sent = Sent::default();
    demo.component.set_opener(Box::new(FakeOpener(Arc::clone(&sent))));
    let value = json!({ "frame": "left", "values": [3.0] });
    let subscription = FakeSubscription(vec![value.clone()]);
    demo.component.bind_in(demo.port("ins"), Some("left"), Some(Box::new(subscription)));
    let mut frame = demo.begin("many", json!({ "id": "left" }));
    assert_eq!(demo.call(&mut *frame, "n_start"), "::genom::no_such_outport");
    assert_eq!(*sent.lock().unwrap(), [value]);
    let seen = frame.output().to_json();
    let seen = seen["seen"].as_str().unwrap();
    let expected = "::genom::no_such_outport; 2; name of a port's element: \"a b\" has";
    assert!(seen.starts_with(expected), "{seen}");
}

#[test]
fn exceptions_thrown_are_events_with_their_detail() {
    let demo = load(&axis(), AXIS);
    let thrown = |to: f64| {
        let mut frame = demo.begin("move", json!({ "to": to }));
        let event = demo.call(&mut *frame, "m_start");
        (event, frame.detail().unwrap_or_default())
    };
    let (event, detail) = thrown(1.0);
    assert_eq!((event.as_str(), &detail["what"]), ("::genom::unkex", &json!("no driver")));
    assert_eq!(demo.task("t_start"), "::demo::ether");
    assert_eq!(thrown(1.0), ("::demo::main".to_owned(), Value::Null));
    assert_eq!(thrown(11.0), ("::demo::EMPTY".to_owned(), Value::Null));
    let what = "too far, as the axis ends before";
    let detail = json!({ "limit": 20.0, "what": what, "tried": [1, 2] });
    assert_eq!(thrown(21.0), ("::demo::TOO_FAR".to_owned(), detail));
    // Of a type derived from that of the description.
    let detail = json!({ "limit": 30.0, "what": "", "tried": [] });
    assert_eq!(thrown(31.0), ("::demo::TOO_FAR".to_owned(), detail));
    assert_eq!(thrown(-21.0), ("::genom::syserr".to_owned(), json!({ "code": 2 })));
    assert_eq!(thrown(-11.0).0, "::demo::elsewhere");
    let (event, detail) = thrown(101.0);
    assert_eq!(event, "::genom::unkex");
    assert_eq!(detail["what"], "C++ exception of type double");
}

#[test]
fn attributes_move_values_between_requests_and_the_ids_of_cxx() {
    // genom3.md 7.3.6, with std::string and std::vector.
    let demo = load(&axis(), AXIS);
    demo.task("t_start");
    let mut frame = demo.begin("set_frame", json!({ "frame": "" }));
    assert_eq!(demo.call(&mut *frame, "v_frame"), "::demo::EMPTY");
    let name = "a name that is too long for a small string";
    let mut frame = demo.begin("set_frame", json!({ "frame": name }));
    assert_eq!(demo.call(&mut *frame, "v_frame"), "");
    frame.store();
    let mut frame = demo.begin("get_frame", json!({}));
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "frame": name, "steps": [7, 7] }));
    let mut frame = demo.begin("swap_count", json!({ "count": 3 }));
    frame.store();
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "count": 3 }));
}

#[test]
fn a_member_of_a_sequence_that_is_too_short_is_told() {
    let demo = load(&axis(), AXIS);
    let mut frame = demo.begin("move", json!({ "to": 1.0 }));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::genom::unkex");
    let detail = frame.detail().unwrap();
    assert_eq!(detail["what"], "argument `step` of codel m_main: the sequence has no such element");
}
