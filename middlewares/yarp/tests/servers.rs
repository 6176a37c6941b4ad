//! Remotes call servers of YARP that are no genomd: a genuine one, and some that answer anything.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code outside of test functions")]

mod world;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use genom_components::peer::Lines;
use genom_middleware::reply::{ReplyReceiver, pair};
use genom_middleware::{
    Address, CallError, Discovery as _, EndpointKind, Middleware as _, Outcome, PortSpec,
    Ports as _, ServiceKind, ServiceType, Services as _,
};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use genom_yarp::{Options, Yarp};
use serde_json::{Value, json};
use world::{Place, until};

/// Only a failing test waits this long.
const PATIENCE: Duration = Duration::from_secs(60);

const MISFIT: &str = "an answer that does not fit its service";

fn parameters(name: &str, members: Vec<(&str, Kind)>) -> DataType {
    let mut types = TypeTable::default();
    let member = |(name, kind): (&str, Kind)| Member { name: name.to_owned(), ty: types.add(kind) };
    let members = members.into_iter().map(member).collect();
    let name = ScopedName::new(["hand", name]);
    let id = types.add(Kind::Struct { name, members });
    DataType::new(&Arc::new(types), id).unwrap()
}

/// `close(in double width, in string side, out double force, out boolean held)`.
fn close() -> ServiceType {
    let input = vec![("width", Kind::Double), ("side", Kind::String { bound: None })];
    let output = vec![("force", Kind::Double), ("held", Kind::Boolean)];
    let (input, output) = (parameters("input", input), parameters("output", output));
    ServiceType::new(ServiceKind::Function, input, output)
}

/// The same inputs, and other outputs.
fn closing(output: Vec<(&str, Kind)>) -> ServiceType {
    ServiceType::new(ServiceKind::Activity, close().input, parameters("other", output))
}

/// Asks for a width of 0.5 on the left.
fn ask(yarp: &Arc<Yarp>, at: &Address, service: &ServiceType) -> ReplyReceiver {
    let mut client = yarp.client(at, service).unwrap();
    let (replies, answer) = pair();
    client.request(&input(service), Box::new(replies)).unwrap();
    answer
}

fn input(service: &ServiceType) -> Record {
    let mut input = Record::new(&service.input);
    input.merge_json(&json!({"width": 0.5, "side": "to the left"})).unwrap();
    input
}

/// The outcome as JSON; an exception with its name, an error as its text.
fn told(answer: &ReplyReceiver) -> Value {
    match answer.wait(PATIENCE) {
        Ok(Outcome::Success(output)) => output.to_json(),
        Ok(Outcome::Exception { name, detail }) => json!([name, detail]),
        Ok(Outcome::Lost(error)) | Err(error) => json!(error.to_string()),
    }
}

fn refused(yarp: &Yarp, why: &str) -> u64 {
    let all = yarp.refused();
    all.iter().find(|one| one.why == why).map_or(0, |one| one.count)
}

/// The next line of `yarp rpcserver` that begins so.
fn says(server: &Lines, beginning: &str) -> String {
    loop {
        let line = server.line(beginning);
        if line.starts_with(beginning) {
            return line;
        }
    }
}

#[test]
fn a_remote_calls_a_genuine_server_of_yarp() {
    let place = Place::new();
    let yarp = place.open();
    let mut server = place.peer(&["rpcserver", "/hand/rpc"]);
    let at = Address::new("hand", "close");
    let shows = || {
        let ends = yarp.ends_at(&at).unwrap();
        ends.iter().any(|end| end.kind == EndpointKind::Service && end.address == "hand/close")
    };
    // It is registered before it listens.
    says(&server, "Waiting for a message...");
    assert!(shows());
    let (held, truth) = (close(), closing(vec![("done", Kind::Boolean)]));
    let (text, nothing) = (closing(vec![("word", Kind::String { bound: None })]), closing(vec![]));
    let failed = |said: &str| json!(format!("yarp failed: /hand/rpc answers {said}"));
    for (service, reply, outcome) in [
        (&held, "[ok] 2.5 1", json!({"force": 2.5, "held": true})),
        (&held, "ok 2 0", json!({"force": 2.0, "held": false})),
        (&held, "2.5 1", json!({"force": 2.5, "held": true})),
        (&held, "[fail] \"no such hand\"", failed("[fail] \"no such hand\"")),
        (&held, "fail", failed("fail")),
        (&held, "exception \"::hand::STUCK\"", json!(["::hand::STUCK", null])),
        (
            &held,
            r#"exception "::hand::STUCK" "{\"force\":7}""#,
            json!(["::hand::STUCK", {"force": 7}]),
        ),
        (&truth, "[ok]", json!({"done": true})),
        (&truth, "[fail]", json!({"done": false})),
        (&truth, "1", json!({"done": true})),
        (&text, "fail", json!({"word": "fail"})),
        (&text, "[fail]", failed("[fail]")),
        (&text, "ok fail", json!({"word": "fail"})),
        (&nothing, "[ok]", json!({})),
        (&nothing, "[ack]", json!({})),
        (&nothing, "[done]", json!({})),
    ] {
        let answer = ask(&yarp, &at, service);
        let request = says(&server, "Message: ");
        assert_eq!(request, "Message: close 0.5 \"to the left\"");
        server.tell(reply);
        assert_eq!(told(&answer), outcome, "{reply}");
    }
    assert_eq!(refused(&yarp, MISFIT), 0);
    let answer = ask(&yarp, &at, &held);
    says(&server, "Message: ");
    server.tell("2.5 1 7");
    let why = "/hand/rpc answers close, and the value has 1 too many: it wants 2 members";
    let said = told(&answer);
    assert!(said.as_str().unwrap().ends_with(why), "{said}");
    assert_eq!(refused(&yarp, MISFIT), 1);
}

/// A server at a port of YARP, as it is seen from the network.
struct Server(TcpListener);

impl Server {
    fn new(place: &Place, name: &str) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let port = listener.local_addr().unwrap().port();
        place.ask(&format!("register {name} tcp 127.0.0.1 {port}")).unwrap();
        Self(listener)
    }

    /// Takes a connection and a request.
    fn asked(&self) -> TcpStream {
        let (mut stream, _) = self.0.accept().unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        // The greeting is a number, a length and a name; what answers it is a number, too.
        stream.read_exact(&mut [0; 8 + 4 + b"admin\0".len()]).unwrap();
        stream.write_all(b"YA\0\0\0\0RP").unwrap();
        until(&mut stream, b"to the left").unwrap();
        stream
    }
}

fn word(word: u32) -> Vec<u8> {
    word.to_le_bytes().to_vec()
}

/// The head of a list of which each element says what it is.
fn list(count: u32) -> Vec<u8> {
    [word(256), word(count)].concat()
}

fn float(value: f64) -> Vec<u8> {
    [word(10), value.to_le_bytes().to_vec()].concat()
}

fn int(value: u32) -> Vec<u8> {
    [word(1), word(value)].concat()
}

fn text(text: &str) -> Vec<u8> {
    [word(4), word(text.len() as u32), text.as_bytes().to_vec()].concat()
}

fn vocab(letters: [u8; 4]) -> Vec<u8> {
    [word(9), letters.to_vec()].concat()
}

fn bottle(items: &[Vec<u8>]) -> Vec<u8> {
    [list(items.len() as u32), items.concat()].concat()
}

#[test]
fn an_answer_that_does_not_fit_is_refused_with_the_reason_and_counted() {
    let place = Place::new();
    let yarp = place.open();
    let server = Server::new(&place, "/hand/left");
    // `close` of the port `/hand/left`.
    let (at, service) = (Address::new("hand", "left/close"), close());
    let exception = |rest: &[Vec<u8>]| bottle(&[&[text("exception")][..], rest].concat());
    let deep: Vec<u8> = (0..500).flat_map(|_| list(1)).collect();
    let answers = [
        (bottle(&[]), "`force` wants a number, and nothing is left"),
        (bottle(&[float(1.5)]), "`held` wants 0 or 1, and nothing is left"),
        (bottle(&[float(1.5), int(1), int(7)]), "the value has 1 too many: it wants 2 members"),
        (bottle(&[text("far"), int(1)]), "`force` wants a number, not the text \"far\""),
        (bottle(&[float(1.5), int(2)]), "`held` wants 0 or 1, not the integer 2"),
        (bottle(&[float(1.5), text("1")]), "`held` wants 0 or 1, not the text \"1\""),
        (bottle(&[vocab(*b"ok\0\0"), int(1)]), "`held` wants 0 or 1, and nothing is left"),
        (bottle(&[text("ok")]), "`force` wants a number, and nothing is left"),
        (bottle(&[vocab(*b"is\0\0"), int(1)]), "`force` wants a number, not a vocab"),
        (bottle(&[bottle(&[float(1.5), int(1)])]), "`force` wants a number, not a list of 2"),
        (exception(&[]), "the name of an exception is ::NAME::NAME, not nothing"),
        (exception(&[int(5)]), "the name of an exception is ::NAME::NAME, not the integer 5"),
        (exception(&[text("STUCK")]), "the name of an exception is ::NAME::NAME, not \"STUCK\""),
        (exception(&[text("::hand::")]), "an exception is ::NAME::NAME, not \"::hand::\""),
        (exception(&[text("::hand::STUCK"), text("{")]), "to be a text in JSON: EOF while"),
        (exception(&[text("::hand::STUCK"), int(5)]), "to be a text in JSON: the integer 5"),
        (exception(&[text("::hand::STUCK"), text("{}"), int(5)]), "the integer 5 follows it"),
        (b"HTTP/1.1 200 OK\r\n\r\n".to_vec(), "that is no bottle: it has a value of the unknown"),
        ([word(256), word(u32::MAX)].concat(), "that is no bottle: it has a negative length"),
        ([list(1), word(3)].concat(), "that is no bottle: it has a value of the unknown kind 3"),
        (
            [list(2), word(12), word(1 << 31)].concat(),
            "that is no bottle: it has a negative length",
        ),
        (deep, "that is no bottle: it has lists within lists"),
    ];
    for (count, (answer, why)) in (1..).zip(&answers) {
        let asking = ask(&yarp, &at, &service);
        server.asked().write_all(answer).unwrap();
        let said = told(&asking).as_str().unwrap().to_owned();
        let begins =
            said.starts_with("the answer cannot be decoded: /hand/left answers left/close");
        assert!(begins && said.contains(why), "{why}: {said}");
        assert_eq!(refused(&yarp, MISFIT), count);
    }
    // The connection is closed meanwhile: before an answer, amid one, and after its announcement.
    for answer in [vec![], bottle(&[float(1.5), int(1)])[..20].to_vec(), list(i32::MAX as u32)] {
        let asking = ask(&yarp, &at, &service);
        server.asked().write_all(&answer).unwrap();
        assert_eq!(told(&asking), CallError::Gone.to_string());
    }
    let all = yarp.refused();
    assert!(all.iter().all(|one| one.peer == Some([127, 0, 0, 1].into())), "{all:?}");
    // The next one is served.
    let asking = ask(&yarp, &at, &service);
    server.asked().write_all(&bottle(&[vocab(*b"ok\0\0"), float(1.5), int(1)])).unwrap();
    assert_eq!(told(&asking), json!({"force": 1.5, "held": true}));
}

#[test]
fn an_answer_without_an_end_takes_no_memory_and_no_more_than_its_time() {
    let place = Place::new();
    let yarp = place.open();
    let server = Server::new(&place, "/hand/rpc");
    let (at, service) = (Address::new("hand", "close"), close());
    let asking = ask(&yarp, &at, &service);
    let mut stream = server.asked();
    stream.write_all(&[word(256 + 10), word(i32::MAX as u32)].concat()).unwrap();
    let flood = vec![0; 1 << 16];
    // Until the other side gives up.
    while stream.write_all(&flood).is_ok() {}
    let why = "yarp failed: it answers with more than 65536 bytes";
    assert_eq!(told(&asking), why);
    assert_eq!(refused(&yarp, "an answer that is too long"), 1);
    // One byte at a time, as long as somebody listens.
    let asking = ask(&yarp, &at, &service);
    let mut stream = server.asked();
    let dripping = thread::spawn(move || {
        let _ = stream.write_all(&[word(256 + 32), word(i32::MAX as u32)].concat());
        stream.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        // The end of the connection, or none within that time.
        while stream.read(&mut [0]).is_err() && stream.write_all(&[0]).is_ok() {}
    });
    let said = told(&asking).as_str().unwrap().to_owned();
    assert!(said.ends_with("stopped amid its answer"), "{said}");
    dripping.join().unwrap();
    assert_eq!(refused(&yarp, "an answer without an end"), 1);
}

#[test]
fn a_server_that_never_answers_is_waited_for_as_long_as_the_configuration_says() {
    let place = Place::new();
    let options = Options { answer_within: 0.25, ..place.options() };
    let yarp = Yarp::open(&options).unwrap();
    let server = Server::new(&place, "/hand/rpc");
    let (at, service) = (Address::new("hand", "close"), close());
    let asking = ask(&yarp, &at, &service);
    let mut stream = server.asked();
    assert_eq!(told(&asking), CallError::Timeout(Duration::from_millis(250)).to_string());
    // The connection is closed, so that calls that are given up do not pile up.
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    // Who answers is heard; one that is no port at all is told apart.
    let asking = ask(&yarp, &at, &service);
    server.asked().write_all(&bottle(&[float(1.5), int(1)])).unwrap();
    assert_eq!(told(&asking), json!({"force": 1.5, "held": true}));
    let asking = ask(&yarp, &at, &service);
    let (mut web, _) = server.0.accept().unwrap();
    web.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n").unwrap();
    let said = told(&asking).as_str().unwrap().to_owned();
    assert!(said.contains("is no YARP port: it says HTTP/1.1 400"), "{said}");
    drop(server);
    assert_eq!(told(&ask(&yarp, &at, &service)), CallError::Nobody { address: at }.to_string());
}

#[test]
fn addresses_name_the_port_of_a_server_and_its_service() {
    let place = Place::new();
    let options = Options { prefix: "/robot".to_owned(), ..place.options() };
    let yarp = Yarp::open(&options).unwrap();
    let service = close();
    for (name, at) in [
        ("/robot/hand/rpc", Address::new("hand", "close")),
        ("/robot/hand/left", Address::new("hand", "left/close")),
        ("/robot/hand/left/cmd", Address::new("hand", "left/cmd/close")),
        // Absolute, and so without the prefix.
        ("/gripper/cmd", Address::new("", "gripper/cmd/close")),
    ] {
        let shows = || {
            let ends = yarp.ends_at(&at).unwrap();
            ends.iter().filter(|end| end.kind == EndpointKind::Service).count()
        };
        assert_eq!(shows(), 0, "{name}");
        let server = Server::new(&place, name);
        assert_eq!(shows(), 1, "{name}");
        let asking = ask(&yarp, &at, &service);
        server.asked().write_all(&bottle(&[float(1.5), int(1)])).unwrap();
        assert_eq!(told(&asking), json!({"force": 1.5, "held": true}), "{name}");
    }
    // A port of a genomd that serves nothing is no server, and neither is a name that is none.
    let output = service.output.clone();
    let arm = Address::new("arm", "pose");
    let _writer = yarp.publisher(&PortSpec::new(&arm, &output)).unwrap();
    let at = Address::new("arm", "pose/close");
    let mut client = yarp.client(&at, &service).unwrap();
    let called = client.call(&input(&service), PATIENCE).map(|_| ());
    assert_eq!(called, Err(CallError::Nobody { address: at.clone() }));
    assert!(yarp.ends_at(&at).unwrap().is_empty());
    let error = yarp.client(&Address::new("arm", "a b/close"), &service).err().unwrap();
    assert!(error.to_string().contains("is no name on YARP"), "{error}");
}
