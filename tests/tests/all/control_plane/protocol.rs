//! The control plane matches the protocol crate: routes, types and replies.

use std::collections::BTreeSet;

use genom_protocol::routes::{self, Listed, Route};
use genom_protocol::{MiddlewareParameters, ReadyParameters, openapi};
use genom_tests::{Daemon, request};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// Types in streams and recordings, to which no operation of the document refers.
const STREAMED: [&str; 10] = [
    "Change",
    "LogEntry",
    "PlotColumns",
    "Plots",
    "RecordingChannel",
    "RecordingEnd",
    "RecordingLoss",
    "RecordingStart",
    "StreamEnd",
    "Timeline",
];

fn document(daemon: &Daemon) -> Value {
    request(&daemon.home().socket(), "GET", "/openapi.json", "").body
}

/// Name of the type that a `$ref` refers to.
fn name(reference: &str) -> String {
    reference.rsplit('/').next().unwrap_or_default().to_owned()
}

/// Collects the names of the types that a part of the document refers to, in order.
fn named(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            found.extend(members.get("$ref").and_then(Value::as_str).map(name));
            members.values().for_each(|value| named(value, found));
        }
        Value::Array(all) => all.iter().for_each(|value| named(value, found)),
        _ => {}
    }
}

#[test]
fn the_document_has_the_types_of_the_protocol_and_no_others() {
    let daemon = Daemon::start(&[]);
    let document = document(&daemon);
    let told = document["components"]["schemas"].as_object().unwrap();
    let ours = openapi::schemas();
    let names = |all: &serde_json::Map<String, Value>| all.keys().cloned().collect::<BTreeSet<_>>();
    assert_eq!(names(told), names(&ours));
    for (name, schema) in &ours {
        assert_eq!(told[name], *schema, "{name}");
    }
    // Every type is used: by an operation, by a stream, or by another type that is used.
    let mut waiting: Vec<String> = STREAMED.map(str::to_owned).to_vec();
    named(&document["paths"], &mut waiting);
    let mut said = BTreeSet::new();
    while let Some(name) = waiting.pop() {
        named(&ours[&name], &mut waiting);
        waiting.retain(|name| !said.contains(name));
        said.insert(name);
    }
    assert_eq!(said, names(&ours));
}

/// What the document says of a content: the name of its type, or its format.
fn told_of(content: &Value) -> Vec<String> {
    let Some((kind, media)) = content.as_object().and_then(|all| all.iter().next()) else {
        return vec!["()".to_owned()];
    };
    match kind.as_str() {
        "application/json" => {
            let mut names = Vec::new();
            named(&media["schema"], &mut names);
            if names.is_empty() { vec!["Value".to_owned()] } else { names }
        }
        "text/event-stream" => vec!["Stream".to_owned()],
        _ => vec!["Bytes".to_owned()],
    }
}

#[test]
fn routes_are_those_of_the_document_and_answer_the_types_that_it_tells() {
    let daemon = Daemon::start(&[]);
    let document = document(&daemon);
    let mut left = routes::all();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let here = |one: &Listed| {
                one.template == path && one.method.as_str().eq_ignore_ascii_case(method)
            };
            let Some(at) = left.iter().position(here) else {
                panic!("{method} {path} is no route of the protocol");
            };
            let route = left.swap_remove(at);
            let asked = match route.right {
                Some(right) => json!([{ "token": [right] }]),
                None => json!([{}]),
            };
            assert_eq!(operation["security"], asked, "{method} {path}");
            let responses = operation["responses"].as_object().unwrap();
            let good = responses.iter().filter(|(status, _)| status.starts_with('2'));
            let replies: Vec<_> = good.flat_map(|(_, reply)| told_of(&reply["content"])).collect();
            // The caller cannot know which of these it gets.
            let several = route.reply == "CallReply" && replies == ["Outcome", "Started"];
            assert!(several || replies == [route.reply], "{method} {path}: {replies:?}, {route:?}");
            let bodies = told_of(&operation["requestBody"]["content"]);
            assert_eq!(bodies, [route.body], "{method} {path}");
        }
    }
    assert!(left.is_empty(), "the daemon has no such routes: {left:#?}");
}

/// Sends a request, reads the reply as its route's type, and serialises it again; nothing must be
/// lost, so the type has everything that the daemon sends.
#[track_caller]
fn read_whole<R: DeserializeOwned + Serialize, Q, B>(daemon: &Daemon, route: &Route<R, Q, B>) -> R {
    let reply = request(&daemon.home().socket(), route.method.as_str(), &route.path, "{}");
    assert_eq!(reply.status / 100, 2, "{route:?}: {}", reply.body);
    let read: R = serde_json::from_value(reply.body.clone())
        .unwrap_or_else(|error| panic!("{route:?}: {error}: {}", reply.body));
    assert_eq!(serde_json::to_value(&read).unwrap(), reply.body, "{route:?}");
    read
}

#[test]
fn replies_are_read_without_loss() {
    let daemon = Daemon::demo("local");
    daemon.ctl(&["pub", "demo/parameter", "1"]).expect_code(0);
    read_whole(&daemon, &routes::about());
    read_whole(&daemon, &routes::ready().with(&ReadyParameters::default()));
    read_whole(&daemon, &routes::components());
    let described = read_whole(&daemon, &routes::component("demo"));
    for service in &described.services {
        read_whole(&daemon, &routes::service("demo", &service.name));
    }
    read_whole(&daemon, &routes::call("demo", "get_position"));
    read_whole(&daemon, &routes::call("demo", "goto"));
    read_whole(&daemon, &routes::activities("demo"));
    read_whole(&daemon, &routes::activity("demo", "goto"));
    read_whole(&daemon, &routes::abort("demo", "goto"));
    read_whole(&daemon, &routes::abort_all("demo"));
    read_whole(&daemon, &routes::stop());
    read_whole(&daemon, &routes::ports());
    read_whole(&daemon, &routes::ports_of("demo"));
    for port in &described.ports {
        read_whole(&daemon, &routes::port("demo", &port.name));
        read_whole(&daemon, &routes::port_type("demo", &port.name));
        read_whole(&daemon, &routes::traffic("demo", &port.name));
        read_whole(&daemon, &routes::why("demo", &port.name));
    }
    read_whole(&daemon, &routes::statistics("demo"));
    read_whole(&daemon, &routes::connections());
    read_whole(&daemon, &routes::dump());
    read_whole(&daemon, &routes::logs());
    read_whole(&daemon, &routes::clock());
    let visible = MiddlewareParameters { visible: true, ..Default::default() };
    read_whole(&daemon, &routes::middlewares().with(&visible));
    read_whole(&daemon, &routes::daemons());
    read_whole(&daemon, &routes::disconnect("demo", "parameter"));
    read_whole(&daemon, &routes::unload("demo"));
}
