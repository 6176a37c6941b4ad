//! Genuine programs of YARP do with our ports what they do with their own.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code outside of test functions")]

mod world;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_components::peer::Lines;
use genom_conformance::samples::{note, number, numbered, set_number, state};
use genom_conformance::{World as _, eventually};
use genom_middleware::{
    ActivityId, Address, Discovery, EndpointKind, Middleware, Outcome, Policy, PortSpec, Ports,
    Reading, Replies, ServiceHandler, ServiceKind, ServiceType, Services,
};
use genom_types::Record;
use genom_yarp::Yarp;
use serde_json::{Value, json};
use world::Place;

fn position() -> Address {
    Address::new("demo", "position")
}

/// A state as YARP prints it.
fn printed(n: u64) -> String {
    let values: Vec<String> = (0..7).map(|i| format!("{}.0", n + i)).collect();
    format!("{n} ({})", values.join(" "))
}

#[test]
fn yarp_read_prints_an_out_port_from_its_last_value_on() {
    let place = Place::new();
    let yarp = place.open();
    let mut writer = yarp.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(41)).unwrap();
    let peer = place.peer(&["read", "/r", "/demo/position"]);
    peer.says(&printed(41));
    for n in 42..60 {
        writer.publish(&numbered(n)).unwrap();
        peer.says(&printed(n));
    }
    assert_eq!(writer.dropped(), 0);
}

#[test]
fn yarp_connect_and_disconnect_work_on_an_out_port_with_each_carrier() {
    let place = Place::new();
    let yarp = place.open();
    let mut writer = yarp.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let peer = place.peer(&["read", "/r"]);
    eventually("the reader is there", || place.prints(&["ping", "/r"]).contains("This is"));
    for (n, carrier) in [(1, "tcp"), (2, "fast_tcp"), (3, "tcp")] {
        let said = place.prints(&["connect", "/demo/position", "/r", carrier]);
        assert!(said.contains("Success: Added connection from /demo/position to"), "{said}");
        writer.publish(&numbered(n)).unwrap();
        eventually("the sample is printed", || peer.line("a sample") == printed(n));
        let said = place.prints(&["ping", "/demo/position"]);
        assert!(said.contains("/demo/position") && said.contains(carrier), "{said}");
        let said = place.prints(&["disconnect", "/demo/position", "/r"]);
        assert!(said.contains("Removed connection from /demo/position to /r"), "{said}");
    }
    writer.publish(&numbered(9)).unwrap();
    for (arguments, why) in [
        (["connect", "/demo/position", "/nobody"], "/nobody"),
        (["connect", "/r", "/demo/position"], "Outputs not allowed"),
        (["disconnect", "/demo/position", "/r"], "no such connection"),
    ] {
        let said = place.prints(&arguments);
        assert!(said.contains(why), "{arguments:?}: {said}");
    }
    let said = place.prints(&["connect", "/demo/position", "/r", "udp"]);
    assert!(said.contains("udp"), "{said}");
    assert_eq!(peer.heard(), None, "nothing came without a connection");
}

/// Reads until a sample arrives.
fn read(reader: &mut dyn genom_middleware::Subscription, got: &mut Record) {
    eventually("the sample arrives", || reader.read(got) == Ok(Reading::New));
}

#[test]
fn an_in_port_connects_to_a_port_of_yarp_that_comes_and_goes() {
    let place = Place::new();
    let yarp = place.open();
    let at = Address::new("morse", "robot/pose");
    let ty = state();
    let mut reader = yarp.subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap();
    let mut got = Record::new(&ty);
    assert_eq!(reader.read(&mut got), Ok(Reading::Never));
    for round in 1..3 {
        let mut peer = place.peer(&["write", "/morse/robot/pose"]);
        let reads =
            || place.prints(&["ping", "/morse/robot/pose"]).contains("/morse/robot/pose:i/");
        eventually("it is connected", reads);
        for n in [10 * round, 10 * round + 1] {
            // Integers where numbers are due, as people type them.
            let values: Vec<String> = (0..7).map(|i| (n + i).to_string()).collect();
            peer.tell(&format!("{n} ({})", values.join(" ")));
            read(&mut *reader, &mut got);
            assert_eq!(number(&got), n);
        }
    }
    assert_eq!(reader.dropped(), 0);
}

#[test]
fn a_bottle_that_is_no_sample_is_counted_and_the_value_stays() {
    let place = Place::new();
    let yarp = place.open();
    let (at, ty) = (Address::new("far", "note"), note());
    let mut reader = yarp.subscription(&PortSpec::new(&at, &ty), Policy::Queue(8)).unwrap();
    let mut got = Record::new(&ty);
    let mut peer = place.peer(&["write", "/far/note"]);
    let reads = || place.prints(&["ping", "/far/note"]).contains("/far/note:i/");
    eventually("it is connected", reads);
    peer.tell(r#""a text" ((1 2 3) () (4))"#);
    read(&mut *reader, &mut got);
    assert_eq!(got.to_json(), json!({"text": "a text", "rows": [[1, 2, 3], [], [4]]}));
    let wrong = ["7 ()", "text", "text () more", "text ((1 (2)))", "text ((1 x))", "(text ())", ""];
    for (count, bottle) in (1..).zip(wrong.iter().filter(|bottle| !bottle.is_empty())) {
        peer.tell(bottle);
        eventually("it is counted", || reader.dropped() == count);
    }
    assert_eq!(reader.read(&mut got), Ok(Reading::Same));
    let refused = yarp.refused();
    let why = "a bottle that is no sample of its port's type";
    assert!(refused.iter().any(|one| one.why == why && one.count == 6), "{refused:?}");
    peer.tell("again ()");
    read(&mut *reader, &mut got);
    assert_eq!(got.to_json(), json!({"text": "again", "rows": []}));
}

/// Adds 1000 at once, or runs until it is cancelled.
#[derive(Default)]
struct Adder {
    activity: bool,
    running: Mutex<Vec<Box<dyn Replies>>>,
}

impl ServiceHandler for Adder {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        let n = number(&input);
        if self.activity {
            replies.accepted(ActivityId(n));
            replies.feedback("::demo::main");
            self.running.lock().unwrap().push(replies);
        } else if n == 100 {
            let name = "::demo::TOO_FAR_AWAY".to_owned();
            replies.finish(Outcome::Exception { name, detail: json!({"distance": 1.5}) });
        } else {
            replies.finish(Outcome::Success(numbered(n + 1000)));
        }
    }

    fn cancel(&self, _: ActivityId) {
        for replies in self.running.lock().unwrap().drain(..) {
            let name = "::genom::interrupted".to_owned();
            replies.finish(Outcome::Exception { name, detail: Value::Null });
        }
    }
}

fn service(kind: ServiceKind) -> ServiceType {
    ServiceType::new(kind, state(), state())
}

/// Serves `demo/add`, a function, and `demo/go`, an activity.
fn serve(yarp: &Arc<Yarp>) -> [Box<dyn genom_middleware::Served>; 2] {
    let (add, go) = (Address::new("demo", "add"), Address::new("demo", "go"));
    let activity = Arc::new(Adder { activity: true, ..Adder::default() });
    [
        yarp.serve(&add, &service(ServiceKind::Function), Arc::new(Adder::default())).unwrap(),
        yarp.serve(&go, &service(ServiceKind::Activity), activity).unwrap(),
    ]
}

fn ask(peer: &mut Lines, request: &str) -> String {
    peer.tell(request);
    let mut said = peer.line(request);
    while said.starts_with("[INFO]") {
        said = peer.line(request);
    }
    said
}

#[test]
fn people_call_services_with_yarp_rpc() {
    let place = Place::new();
    let yarp = place.open();
    let _served = serve(&yarp);
    let mut peer = place.peer(&["rpc", "/demo/rpc"]);
    let input = printed(5);
    assert_eq!(ask(&mut peer, &format!("add {input}")), format!("Response: ok {}", printed(1005)));
    let typed = "add 5 (5 6 7 8 9 10 11)";
    assert_eq!(ask(&mut peer, typed), format!("Response: ok {}", printed(1005)));
    let far = ask(&mut peer, &format!("add {}", printed(100)));
    assert_eq!(far, r#"Response: exception "::demo::TOO_FAR_AWAY" "{\"distance\":1.5}""#);
    for (request, said) in [
        ("subtract 5", "nobody \"demo has no service `subtract`; it has: add, go\""),
        ("add 5", "`values` wants a list of 7, and nothing is left"),
        ("add x ()", "`count` wants an integer (i64), not the text \\\"x\\\""),
        ("add 5 (1 2 3)", "`values` wants a list of 7, not a list of 3"),
        ("add 5 (5 6 7 8 9 10 11) 6", "has 1 too many"),
        ("(add)", "a list of 1 where the name of a service is expected"),
        ("@start add other 5", "mismatch \"::demo::state"),
        ("@wait go 8", "go has no run 8 that is not over"),
        ("@wait go x", "write `@wait SERVICE NUMBER`"),
    ] {
        let answer = ask(&mut peer, request);
        assert!(answer.starts_with("Response: ") && answer.contains(said), "{request}: {answer}");
    }
    peer.tell("help");
    peer.says("Responses:");
    peer.says("  add count:unsigned long long values:double[7] -> count:unsigned long long values:double[7] (function)");
}

#[test]
fn people_follow_and_cancel_an_activity_with_yarp_rpc() {
    let place = Place::new();
    let yarp = place.open();
    let _served = serve(&yarp);
    let mut peer = place.peer(&["rpc", "/demo/rpc"]);
    let digest = service(ServiceKind::Activity).digest();
    let start = format!("@start go {digest} {}", printed(7));
    assert_eq!(ask(&mut peer, &start), "Response: accepted 7");
    assert_eq!(ask(&mut peer, "@wait go 7"), r#"Response: state "::demo::main""#);
    assert_eq!(ask(&mut peer, "@cancel go 7"), "Response: ok");
    assert_eq!(ask(&mut peer, "@wait go 7"), r#"Response: exception "::genom::interrupted""#);
    // Without a word before it, the answer is the end; another one cancels meanwhile.
    peer.tell(&format!("go {}", printed(8)));
    let mut other = place.peer(&["rpc", "/demo/rpc"]);
    let cancelled = || ask(&mut other, "@cancel go 8") == "Response: ok";
    assert!({ cancelled }());
    let mut ended = None;
    eventually("it ends", || {
        // The second may have come before the first.
        let _ = ask(&mut other, "@cancel go 8");
        ended = peer.heard();
        ended.is_some()
    });
    assert_eq!(ended.unwrap(), r#"Response: exception "::genom::interrupted""#);
}

#[test]
fn yarp_name_list_shows_ports_and_services_and_we_see_those_of_yarp() {
    let place = Place::new();
    let yarp = place.open();
    let _writer = yarp.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let _served = serve(&yarp);
    let list = place.prints(&["name", "list"]);
    for name in ["/demo/position", "/demo/rpc"] {
        let line = format!("registration name {name} ip 127.0.0.1 port ");
        assert!(list.contains(&line), "{list}");
    }
    let _peer = place.peer(&["read", "/grabber/out"]);
    let shows = |address: &str, kind: EndpointKind| {
        let ends = yarp.discover().unwrap();
        ends.iter().any(|end| end.address == address && end.kind == kind)
    };
    eventually("a port of YARP shows", || shows("grabber/out", EndpointKind::Publisher));
    assert!(shows("demo/position", EndpointKind::Publisher));
    assert!(shows("demo/add", EndpointKind::Service) && shows("demo/go", EndpointKind::Service));
    assert!(!shows("root", EndpointKind::Publisher), "the name server is no port to read");
    let status = place.yarp(&["exists", "/demo/position"]).status().unwrap();
    assert!(status.success());
}

#[test]
fn a_connection_that_the_name_server_keeps_is_made_when_the_port_comes() {
    let place = Place::new();
    let peer = place.peer(&["read", "/r"]);
    eventually("the reader is there", || place.leftovers().contains(&"/r".to_owned()));
    let said = place.prints(&["connect", "--persist", "/demo/position", "/r"]);
    let yarp = place.open();
    for n in 1..3 {
        let mut writer = yarp.publisher(&PortSpec::new(&position(), &state())).unwrap();
        writer.publish(&numbered(n)).unwrap();
        assert_eq!(peer.line("a sample"), printed(n), "{said}");
    }
}

#[test]
fn a_name_server_that_ends_and_comes_back_knows_all_ports_again() {
    let place = Place::new();
    let (a, b) = (place.open(), place.open());
    let ty = state();
    let mut writer = a.publisher(&PortSpec::new(&position(), &ty)).unwrap();
    let mut reader = b.subscription(&PortSpec::new(&position(), &ty), Policy::Latest).unwrap();
    let mut got = Record::new(&ty);
    writer.publish(&numbered(1)).unwrap();
    read(&mut *reader, &mut got);
    place.stop();
    let other = Address::new("demo", "other");
    let error = a.publisher(&PortSpec::new(&other, &ty)).err().unwrap().to_string();
    assert!(error.contains("no YARP name server is at 127.0.0.1:"), "{error}");
    assert!(error.contains("yarpserver"), "it says what to do: {error}");
    for n in 2..5 {
        writer.publish(&numbered(n)).unwrap();
        read(&mut *reader, &mut got);
        assert_eq!(number(&got), n, "connections that stand go on");
    }
    place.start();
    eventually("all ports are registered", || {
        let names = place.leftovers();
        names.contains(&"/demo/position".to_owned())
            && names.iter().any(|name| name.starts_with("/demo/position:i/"))
    });
    let peer = place.peer(&["read", "/r", "/demo/position"]);
    peer.says(&printed(4));
    drop((writer, reader));
    eventually("closed ports are gone", || place.leftovers() == ["/r"]);
}

#[test]
fn a_name_of_a_process_that_was_killed_is_taken_over_and_one_of_a_living_is_not() {
    let place = Place::new();
    let yarp = place.open();
    // Registered, and nobody listens there.
    place.ask("register /demo/position tcp 127.0.0.1 1").unwrap();
    let ty = state();
    let mut writer = yarp.publisher(&PortSpec::new(&position(), &ty)).unwrap();
    writer.publish(&numbered(3)).unwrap();
    place.peer(&["read", "/r", "/demo/position"]).says(&printed(3));
    let _peer = place.peer(&["read", "/demo/other"]);
    eventually("it is there", || place.prints(&["ping", "/demo/other"]).contains("This is"));
    let other = Address::new("demo", "other");
    let error = yarp.publisher(&PortSpec::new(&other, &ty)).err().unwrap();
    assert!(matches!(error, genom_middleware::OpenError::Taken { .. }), "{error}");
    let bad = Address::new("demo", "poses/a b");
    let error = yarp.publisher(&PortSpec::new(&bad, &ty)).err().unwrap().to_string();
    assert!(error.contains("\"/demo/poses/a b\" is no name on YARP"), "{error}");
}

#[test]
fn a_prefix_is_before_all_names() {
    let place = Place::new();
    let options = genom_yarp::Options { prefix: "/robot1".to_owned(), ..place.options() };
    let yarp = Yarp::open(&options).unwrap();
    let mut writer = yarp.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(2)).unwrap();
    place.peer(&["read", "/r", "/robot1/demo/position"]).says(&printed(2));
    assert_eq!((&*yarp as &dyn Middleware).spelled(&position()), "robot1/demo/position");
}

#[test]
fn a_reader_that_stopped_holds_up_nobody_and_memory_is_bounded() {
    use rustix::process::{Pid, Signal, kill_process};
    let place = Place::new();
    let yarp = place.open();
    let ty = state();
    let mut writer = yarp.publisher(&PortSpec::new(&position(), &ty)).unwrap();
    writer.publish(&numbered(0)).unwrap();
    let mut stopped = place.yarp(&["read", "/stopped", "/demo/position"]);
    let mut stopped = stopped.stdout(std::process::Stdio::null()).spawn().unwrap();
    let ping = || place.prints(&["ping", "/demo/position"]);
    eventually("it is connected", || ping().contains("to \"/stopped\""));
    kill_process(Pid::from_child(&stopped), Signal::STOP).unwrap();
    let peer = place.peer(&["read", "/r", "/demo/position"]);
    peer.says(&printed(0));
    let mut sample = numbered(0);
    let mut n = 0;
    eventually("samples are dropped for the one that stopped only", || {
        n += 1;
        set_number(&mut sample, n);
        writer.publish(&sample).unwrap();
        peer.says(&printed(n));
        writer.dropped() > 100
    });
    stopped.kill().unwrap();
    stopped.wait().unwrap();
    eventually("its connection is gone", || !ping().contains("/stopped"));
}

#[test]
fn a_call_of_a_component_follows_an_activity_over_yarp() {
    let place = Place::new();
    let (a, b) = (place.open(), place.open());
    let _served = serve(&a);
    let mut client =
        b.client(&Address::new("demo", "add"), &service(ServiceKind::Function)).unwrap();
    for n in 1..50 {
        match client.call(&numbered(n), Duration::from_secs(30)).unwrap() {
            Outcome::Success(output) => assert_eq!(number(&output), n + 1000),
            other => panic!("{other:?}"),
        }
    }
}
