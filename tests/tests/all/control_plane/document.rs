//! The OpenAPI document is complete, and the control plane behaves as it says.

use std::collections::BTreeSet;
use std::fs;

use genom_tests::{Daemon, files, repository, request};
use serde_json::Value;

const METHODS: [&str; 4] = ["get", "put", "post", "delete"];

fn document(daemon: &Daemon) -> Value {
    let reply = request(&daemon.home().socket(), "GET", "/openapi.json", "");
    assert_eq!(reply.status, 200);
    reply.body
}

/// The path with placeholders replaced by names that do not exist.
fn filled(path: &str) -> String {
    let filled: Vec<_> =
        path.split('/').map(|one| if one.starts_with('{') { "none" } else { one }).collect();
    filled.join("/")
}

#[test]
fn every_route_is_in_the_document_and_the_other_way_round() {
    // Routes are added to the router only together with their part of the document.
    for path in files("rs") {
        if path.starts_with(repository().join("daemon/genomd/src")) {
            let text = fs::read_to_string(&path).unwrap();
            for way in [".route(", ".nest(", ".route_service(", ".merge("] {
                assert!(!text.contains(way), "{}: {way}", path.display());
            }
        }
    }
    let daemon = Daemon::start(&[]);
    let document = document(&daemon);
    let paths = document["paths"].as_object().unwrap();
    assert!(paths.len() > 20, "{}", paths.len());
    for (path, item) in paths {
        for method in METHODS {
            // The end of the daemon, and endless streams, are tested elsewhere.
            let endless = [
                ("get", "/events"),
                ("get", "/logs/stream"),
                ("get", "/timeline/stream"),
                ("post", "/recordings"),
            ];
            let endless = endless.contains(&(method, path.as_str()));
            if endless || path == "/shutdown" && method == "post" {
                continue;
            }
            let reply =
                request(&daemon.home().socket(), &method.to_uppercase(), &filled(path), "{}");
            let known = !["no_such_path", "no_such_method"].contains(&reply.code());
            let told = item.get(method).is_some();
            assert_eq!(known, told, "{method} {path}: {} {}", reply.status, reply.body);
            let status = reply.status.to_string();
            let stated = !told || item[method]["responses"].get(&status).is_some();
            assert!(stated, "{method} {path}: {status} is not in the document");
        }
    }
}

#[test]
fn every_operation_says_what_it_does_and_which_right_it_needs() {
    let daemon = Daemon::start(&[]);
    let document = document(&daemon);
    let mut names = BTreeSet::new();
    let mut open = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let what = format!("{method} {path}");
            assert!(names.insert(operation["operationId"].as_str().unwrap()), "{what}");
            assert!(operation["summary"].as_str().is_some_and(|text| !text.is_empty()), "{what}");
            let right = operation["security"][0]["token"][0].as_str();
            match right {
                Some(right) => {
                    assert!(["read", "call", "wire", "admin"].contains(&right), "{what}");
                    // A route needs the right `read` if and only if it changes nothing. A link
                    // to the console has the rights of whoever asks for it; a recording that is
                    // sent leaves nothing here, one that is kept does.
                    let sent = ["/recordings", "/recordings/{number}"].contains(&path.as_str());
                    let looks = method == "get" || sent || path == "/web/links";
                    assert_eq!(looks, right == "read", "{what}");
                }
                None => open.push(what.clone()),
            }
            for (status, response) in operation["responses"].as_object().unwrap() {
                assert!(!response["description"].as_str().unwrap().is_empty(), "{what} {status}");
            }
        }
    }
    // Without a token only these may be read.
    assert_eq!(open, ["get /openapi.json", "get /docs"]);
}

/// Collects every `$ref` in a value.
fn references(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            found.extend(map.get("$ref").and_then(Value::as_str).map(str::to_owned));
            map.values().for_each(|value| references(value, found));
        }
        Value::Array(list) => list.iter().for_each(|value| references(value, found)),
        _ => {}
    }
}

#[test]
fn every_type_that_the_document_names_is_in_it() {
    let daemon = Daemon::start(&[]);
    let document = document(&daemon);
    let mut found = BTreeSet::new();
    references(&document, &mut found);
    assert!(found.contains("#/components/schemas/Refusal"), "{found:?}");
    for reference in found {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(document.pointer(pointer).is_some(), "{reference} is nowhere");
    }
}

#[test]
fn the_page_to_browse_needs_no_network() {
    let page = fs::read_to_string(repository().join("daemon/genomd/src/rpc/docs.html")).unwrap();
    assert!(page.contains("fetch(\"/openapi.json\")"));
    assert!(!page.contains("http://") && !page.contains("https://") && !page.contains("src="));
    let daemon = Daemon::start(&[]);
    assert_eq!(request(&daemon.home().socket(), "GET", "/docs", "").status, 200);
}

#[test]
fn types_of_services_and_ports_are_told_as_json_schema() {
    let daemon = Daemon::demo("local");
    let get = |path: &str| request(&daemon.home().socket(), "GET", path, "").body;
    let all = get("/components/demo/schema");
    let input = &all["services"]["goto"]["input"];
    assert_eq!(input["properties"]["goal"]["default"], 1.0, "{input}");
    assert_eq!(input["properties"]["goal"]["description"], "Position to reach, m");
    assert_eq!(input["additionalProperties"], false);
    let output = &all["services"]["get_position"]["output"];
    assert_eq!(output["properties"]["position"]["description"], "m", "{output}");
    let port = &all["ports"]["position"];
    assert_eq!(port["$ref"], "#/$defs/demo.state", "{port}");
    assert!(port["$defs"]["demo.state"]["properties"]["velocity"].is_object(), "{port}");
    let service = get("/components/demo/services/goto");
    assert_eq!(&service["input_schema"], input);
}
