//! Ports and remotes as codels see them (genom3.md 5.7, 5.8, 7.8), with fakes.

#![allow(clippy::unwrap_used)] // fakes and helpers are no test functions

mod support;

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use genom_description::model::Direction::{In, InOut, Out};
use genom_description::model::{CodelIx, Ix as _, Owner, PortDirection, PortIx, ServiceIx, Source};
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_runtime::body::{Body, ElementError, Frame, Opener, RemoteCall};
use genom_types::{Kind, Record, TypeId};
use serde_json::{Value, json};
use support::generator::Gen;
use support::load::{Loaded, load};

/// What was published, as JSON.
type Sent = Arc<Mutex<Vec<Value>>>;

/// Keeps what is published; fails with the given error.
struct FakePublisher(Sent, Option<PublishError>);

impl Publisher for FakePublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.1.map_or(Ok(()), Err)?;
        self.0.lock().unwrap().push(value.to_json());
        Ok(())
    }
    fn dropped(&self) -> u64 {
        0
    }
}

/// Returns these readings, then `Same`.
struct FakeSubscription(Vec<Result<Value, ReadError>>);

impl Subscription for FakeSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if self.0.is_empty() {
            return Ok(Reading::Same);
        }
        match self.0.remove(0)? {
            Value::Null => Ok(Reading::Never),
            value => {
                into.merge_json(&value).unwrap();
                Ok(Reading::New)
            }
        }
    }
    fn dropped(&self) -> u64 {
        0
    }
}

const HEADER: &str = r#"
    #include <stdint.h>
    #include <string.h>
    #include <genom3/c/context.h>
    #include <genom3/c/exception.h>
    #include <genom3/c/idlsequence.h>
    GENOM_EVENT(genom_no_such_inport_id, "::genom::no_such_inport");
    typedef struct demo_s { int32_t a; char *t; } demo_s;
    typedef struct demo_pin { demo_s *(*data)(genom_context self);
      genom_event (*read)(genom_context self); } demo_pin;
    typedef struct demo_pout { demo_s *(*data)(genom_context self);
      genom_event (*write)(genom_context self); } demo_pout;
    typedef struct demo_min { demo_s *(*data)(const char *id, genom_context self);
      genom_event (*read)(const char *id, genom_context self); } demo_min;
    typedef struct demo_mout { demo_s *(*data)(const char *id, genom_context self);
      genom_event (*write)(const char *id, genom_context self);
      genom_event (*open)(const char *id, genom_context self);
      genom_event (*close)(const char *id, genom_context self); } demo_mout;
"#;

/// A component with a port `p` of struct `s { long a; string t; }` and an activity whose codel gets
/// the port and a number.
fn one_port(
    direction: PortDirection,
    multiple: bool,
    c: &str,
) -> (Loaded, Box<dyn Frame>, CodelIx) {
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let text = gen_.string(None);
    let s = gen_.structure("s", &[("a", long), ("t", text)]);
    let port = gen_.port("p", direction, multiple, s);
    let kind = genom_description::model::ServiceKind::Activity;
    let service = gen_.service(kind, "act", &[(In, "x", long), (Out, "y", long)], &[]);
    let parameter = |index| Source::Parameter { index, path: vec![] };
    let arguments: [(_, _, TypeId, _); 3] = [
        (In, "x", long, parameter(0)),
        (Out, "p", s, Source::Port(port)),
        (Out, "y", long, parameter(1)),
    ];
    let codel = gen_.codel(Owner::Service(service), "f", &arguments);
    let loaded = load(gen_, &format!("{HEADER}{c}"));
    let frame = loaded.begin(service, json!({}));
    (loaded, frame, codel)
}

/// The only port of these components.
fn only_port() -> PortIx {
    PortIx::new(0)
}

/// Calls `f(x, port, &y)`; returns its event, its detail and `y`.
fn step(loaded: &Loaded, frame: &mut dyn Frame, codel: CodelIx, x: i32) -> (String, Value) {
    let ty = loaded.specification.components[0].services[ServiceIx::new(0)].input;
    let input = support::generator::record(&loaded.specification, ty, json!({ "x": x }));
    frame.begin(&input);
    let event = loaded.call(frame, codel);
    (event, frame.output().to_json()["y"].clone())
}

#[test]
fn an_out_port_publishes_what_its_codel_put_in_the_buffer() {
    let c = r#"genom_event f(int32_t x, const demo_pout *p, int32_t *y, genom_context self) {
        demo_s *d = p->data(self);
        *y = d->a;
        d->a = x;
        free(d->t);
        d->t = strdup("text");
        return p->write(self);
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::Out, false, c);
    let mut step = |x| step(&loaded, &mut *frame, codel, x);
    let body = &loaded.component;
    assert_eq!(step(1), ("::genom::no_such_outport".into(), json!(0)));
    assert_eq!(body.port_value(only_port(), None), None);
    let sent = Sent::default();
    body.bind_out(only_port(), None, Some(Box::new(FakePublisher(sent.clone(), None))));
    assert_eq!(step(2), (String::new(), json!(1)), "the buffer is the same between calls");
    assert_eq!(step(3).0, "");
    let values = [json!({ "a": 2, "t": "text" }), json!({ "a": 3, "t": "text" })];
    assert_eq!(*sent.lock().unwrap(), values);
    assert_eq!(body.port_value(only_port(), None), Some(values[1].clone()));
    for (error, event) in [
        (PublishError::Serialization, "::genom::serialization"),
        (PublishError::Refused, "::genom::port_io"),
    ] {
        body.bind_out(only_port(), None, Some(Box::new(FakePublisher(sent.clone(), Some(error)))));
        assert_eq!(step(4).0, event);
    }
    assert_eq!(
        body.port_value(only_port(), None),
        Some(values[1].clone()),
        "only what was published"
    );
    body.bind_out(only_port(), None, None);
    assert_eq!(step(5).0, "::genom::no_such_outport");
}

#[test]
fn an_in_port_shows_nothing_until_a_value_was_read() {
    // `y` is -1 without data, else the member.
    let c = r#"genom_event f(int32_t x, const demo_pin *p, int32_t *y, genom_context self) {
        genom_event last, e = x ? p->read(self) : NULL;
        demo_s *d = p->data(self);
        *y = d ? d->a : -1;
        if (!e) return NULL;
        self->raised(&last, self);
        if (last != e) return "::demo::not_recorded";
        return e == genom_no_such_inport_id ? "::demo::mine" : e;
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::In, false, c);
    let mut step = |x| step(&loaded, &mut *frame, codel, x);
    let body = &loaded.component;
    assert_eq!(step(0), (String::new(), json!(-1)), "unconnected");
    assert_eq!(step(1), ("::demo::mine".into(), json!(-1)), "the library's own pointer");
    let readings = vec![
        Ok(Value::Null),
        Ok(json!({ "a": 7, "t": "x" })),
        Err(ReadError::Serialization),
        Err(ReadError::Broken),
        Ok(json!({ "a": 8 })),
    ];
    body.bind_in(only_port(), None, Some(Box::new(FakeSubscription(readings))));
    assert_eq!(step(0), (String::new(), json!(-1)), "connected, not read");
    assert_eq!(step(1), (String::new(), json!(-1)), "nothing was ever written");
    assert_eq!(step(1), (String::new(), json!(7)));
    assert_eq!(body.port_value(only_port(), None), Some(json!({ "a": 7, "t": "x" })));
    assert_eq!(step(1), ("::genom::serialization".into(), json!(-1)));
    assert_eq!(step(1), ("::genom::port_io".into(), json!(-1)));
    assert_eq!(step(1), (String::new(), json!(8)));
    assert_eq!(step(1), (String::new(), json!(8)), "nothing new: the last value");
    assert_eq!(step(0), (String::new(), json!(8)), "kept between reads");
    body.bind_in(only_port(), None, None);
    assert_eq!(step(0), (String::new(), json!(-1)), "disconnected");
}

/// Opens publishers and records their elements.
struct FakeOpener(Arc<Mutex<Vec<String>>>, Sent);

impl Opener for FakeOpener {
    fn open(&self, port: PortIx, element: &str) -> Result<Box<dyn Publisher>, ElementError> {
        if element == "taken" {
            return Err(ElementError::Open("demo/p/taken already has a publisher".into()));
        }
        self.0.lock().unwrap().push(format!("{port}/{element}"));
        Ok(Box::new(FakePublisher(self.1.clone(), None)))
    }

    fn close(&self, port: PortIx, element: &str) {
        self.0.lock().unwrap().push(format!("closed {port}/{element}"));
    }
}

#[test]
fn elements_of_a_multiple_out_port_are_opened_written_and_closed_by_name() {
    let c = r#"genom_event f(int32_t x, const demo_mout *p, int32_t *y, genom_context self) {
        demo_s *d;
        static char longer[200];
        *y = 0;
        memset(longer, 'n', sizeof(longer) - 1);
        switch (x) {
          case 0: return p->write("a", self);
          case 1: *y = p->data("a", self) == NULL; return NULL;
          case 2: return p->open("a", self);
          case 3: d = p->data("a", self); *y = d->a; d->a++; return p->write("a", self);
          case 4: return p->close("a", self);
          case 5: return p->open("a//b", self);
          case 6: return p->open(NULL, self);
          case 7: return p->open("taken", self);
          case 8: return p->open(longer, self);
          default: return p->data(NULL, self) ? "::demo::data" : p->close(NULL, self);
        }
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::Out, true, c);
    let opened = Arc::new(Mutex::new(vec![]));
    let sent = Sent::default();
    loaded.component.set_opener(Box::new(FakeOpener(opened.clone(), sent.clone())));
    let mut step = |x| {
        let (event, y) = step(&loaded, &mut *frame, codel, x);
        (event, y, frame.detail())
    };
    let mwerr = |what: &str| ("::genom::mwerr".to_owned(), json!(0), what.to_owned());
    let refused = |(event, y, detail): (String, Value, Option<Value>)| {
        let what = detail.expect("mwerr has a detail")["what"].as_str().unwrap().to_owned();
        (event, y, what)
    };
    assert_eq!(step(0).0, "::genom::no_such_outport");
    assert_eq!(step(1).1, json!(1), "no data before open");
    assert_eq!(step(2).0, "");
    assert_eq!(step(2).0, "", "opening again is ok");
    assert_eq!((step(3).1, step(3).1), (json!(0), json!(1)), "the buffer stays");
    assert_eq!(
        loaded.component.port_value(only_port(), Some("a")),
        Some(json!({ "a": 2, "t": "" }))
    );
    assert_eq!(step(4).0, "");
    assert_eq!(step(4), ("::genom::syserr".into(), json!(0), Some(json!({ "code": 2 }))));
    assert_eq!(step(1).1, json!(1));
    assert_eq!(loaded.component.port_value(only_port(), Some("a")), None);
    assert_eq!(
        refused(step(5)),
        mwerr(
            "name of a port's element: \"a//b\" has nothing before, after or between its slashes"
        )
    );
    assert_eq!(refused(step(6)).2, "name of a port's element: NULL");
    assert_eq!(refused(step(7)), mwerr("demo/p/taken already has a publisher"));
    let too_long = ("::genom::syserr".into(), json!(0), Some(json!({ "code": 36 })));
    assert_eq!(step(8), too_long, "codels of real components shorten the name then");
    assert_eq!(step(9).0, "::genom::syserr");
    assert_eq!(*opened.lock().unwrap(), ["0/a", "closed 0/a"]);
    assert_eq!(sent.lock().unwrap().len(), 2);
}

#[test]
fn buffers_that_codels_assign_to_one_another_are_freed_once() {
    // Freeing twice would abort this test.
    let c = r#"#include <stdlib.h>
    genom_event f(int32_t x, const demo_mout *p, int32_t *y, genom_context self) {
        *y = x;
        if (p->open("a", self) || p->open("b", self)) return "::demo::open";
        p->data("a", self)->t = strdup("long enough to come from the heap");
        *p->data("b", self) = *p->data("a", self);
        return p->write("b", self);
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::Out, true, c);
    loaded.component.set_opener(Box::new(FakeOpener(Arc::default(), Sent::default())));
    assert_eq!(step(&loaded, &mut *frame, codel, 1), (String::new(), json!(1)));
    let shown = json!({ "a": 0, "t": "long enough to come from the heap" });
    assert_eq!(loaded.component.port_value(only_port(), Some("b")), Some(shown));
    drop((frame, loaded));
}

#[test]
fn elements_of_a_multiple_in_port_come_with_their_connections() {
    let c = r#"genom_event f(int32_t x, const demo_min *p, int32_t *y, genom_context self) {
        genom_event e = p->read("left", self);
        *y = p->data("left", self) ? p->data("left", self)->a : -1;
        return e;
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::In, true, c);
    let mut step = || step(&loaded, &mut *frame, codel, 0);
    assert_eq!(step(), ("::genom::no_such_inport".into(), json!(-1)));
    let reading = FakeSubscription(vec![Ok(json!({ "a": 4 }))]);
    loaded.component.bind_in(only_port(), Some("left"), Some(Box::new(reading)));
    assert_eq!(step(), (String::new(), json!(4)));
    loaded.component.bind_in(only_port(), Some("left"), None);
    assert_eq!(step(), ("::genom::no_such_inport".into(), json!(-1)));
}

#[test]
fn a_port_used_without_the_codels_context_still_works_and_records_nothing() {
    let c = r#"genom_event f(int32_t x, const demo_pin *p, int32_t *y, genom_context self) {
        struct genom_context_iface other = *self;
        genom_event last, e = p->read(&other), g = p->read(NULL);
        self->raised(&last, self);
        return e && g && !last ? NULL : "::demo::bad";
    }"#;
    let (loaded, mut frame, codel) = one_port(PortDirection::In, false, c);
    assert_eq!(step(&loaded, &mut *frame, codel, 0).0, "");
}

#[test]
fn the_runtime_writes_ports_that_no_codel_writes() {
    let c =
        "genom_event f(int32_t x, const demo_pout *p, int32_t *y, genom_context s) { return 0; }";
    let (loaded, ..) = one_port(PortDirection::Out, false, c);
    let sent = Sent::default();
    loaded.component.bind_out(only_port(), None, Some(Box::new(FakePublisher(sent.clone(), None))));
    let ty = loaded.specification.components[0].ports[PortIx::new(0)].ty;
    let value = json!({ "a": 1, "t": "state" });
    let record = support::generator::record(&loaded.specification, ty, value.clone());
    loaded.component.write_port(only_port(), &record);
    assert_eq!(*sent.lock().unwrap(), std::slice::from_ref(&value));
    assert_eq!(loaded.component.port_value(only_port(), None), Some(value));
}

/// Multiplies, or fails for 13.
struct FakeRemote(Arc<AtomicU32>);

impl RemoteCall for FakeRemote {
    fn call(&mut self, input: &Record, output: &mut Record) -> Result<(), (String, Value)> {
        self.0.fetch_add(1, Ordering::Relaxed);
        let input = input.to_json();
        let a = input["a"].as_i64().unwrap();
        match a {
            13 => Err(("::demo::e".into(), json!({ "code": 6 }))),
            14 => Err(("::other::unknown".into(), Value::Null)),
            _ => {
                let d = format!("{a}-{}", input["s"].as_str().unwrap());
                let b = input["b"].as_array().unwrap().iter().rev().collect::<Vec<_>>();
                let json = json!({ "b": b, "d": d });
                output.merge_json(&json).unwrap();
                Ok(())
            }
        }
    }
}

#[test]
fn a_remote_sends_its_arguments_and_waits_for_the_outputs() {
    // genom3.md 5.10: remote of `function r1(in long a, in string s, inout long b[3], out string d)`
    let mut gen_ = Gen::new();
    let long = gen_.ty(Kind::Long);
    let text = gen_.string(None);
    let three = gen_.ty(Kind::Array { element: long, length: 3 });
    gen_.exception("e", &[("code", long)]);
    let remote = gen_
        .remote("r1", &[(In, "a", long), (In, "s", text), (InOut, "b", three), (Out, "d", text)]);
    let kind = genom_description::model::ServiceKind::Activity;
    let service =
        gen_.service(kind, "act", &[(In, "x", long), (InOut, "b", three), (Out, "d", text)], &[]);
    let parameter = |index| Source::Parameter { index, path: vec![] };
    let codel = gen_.codel(
        Owner::Service(service),
        "f",
        &[
            (In, "x", long, parameter(0)),
            (In, "r1", long, Source::Remote(remote)),
            (InOut, "b", three, parameter(1)),
            (Out, "d", text, parameter(2)),
        ],
    );
    let c = format!(
        r#"{HEADER}
        typedef struct demo_r1 {{
          genom_event (*call)(int32_t a, const char *s, int32_t b[3], char **d, genom_context self);
        }} demo_r1;
        GENOM_EVENT(demo_e_id, "::demo::e");
        genom_event f(int32_t x, const demo_r1 *r1, int32_t b[3], char **d, genom_context self) {{
          char *garbage = (char *)0x1, s[] = "text";
          genom_event e = r1->call(x, s, x == 15 ? NULL : b, &garbage, self);
          if (e == demo_e_id) return e;
          if (e) return e;
          *d = garbage;
          return NULL;
        }}"#
    );
    let loaded = load(gen_, &c);
    let run = |x: i32| {
        let mut frame = loaded.begin(service, json!({ "x": x, "b": [1, 2, 3] }));
        let event = loaded.call(&mut *frame, codel);
        (event, frame.output().to_json(), frame.detail())
    };
    let kept = json!({ "b": [1, 2, 3], "d": "" });
    assert_eq!(run(1), ("::genom::no_such_service".into(), kept.clone(), None));
    let calls = Arc::new(AtomicU32::new(0));
    loaded.component.bind_remote(remote, Some(Box::new(FakeRemote(calls.clone()))));
    assert_eq!(run(12), (String::new(), json!({ "b": [3, 2, 1], "d": "12-text" }), None));
    assert_eq!(run(13), ("::demo::e".into(), kept.clone(), Some(json!({ "code": 6 }))));
    assert_eq!(
        run(14),
        ("::genom::unkex".into(), kept.clone(), Some(json!({ "what": "::other::unknown" })))
    );
    assert_eq!(calls.load(Ordering::Relaxed), 3);
    let said = "argument `b` of r1 is NULL";
    assert_eq!(run(15), ("::genom::unkex".into(), kept.clone(), Some(json!({ "what": said }))));
    assert_eq!(calls.load(Ordering::Relaxed), 3, "nothing was sent");
    loaded.component.bind_remote(remote, None);
    assert_eq!(run(1).0, "::genom::no_such_service");
}
