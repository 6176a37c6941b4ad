//! A daemon whose middleware is YARP, by its library, with genuine programs of YARP.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "test code outside of test functions")]

#[path = "../../tests/world/mod.rs"]
mod world;

use std::io::Write as _;
use std::process::Stdio;

use genom_tests::{Home, component, path, repository};
use world::Place;

/// What `yarp rpc` prints for these lines.
fn asked(place: &Place, port: &str, lines: &str) -> String {
    let mut rpc = place.yarp(&["rpc", port]);
    let mut rpc = rpc.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    rpc.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    String::from_utf8_lossy(&rpc.wait_with_output().unwrap().stdout).into_owned()
}

#[test]
fn programs_of_yarp_read_and_call_a_component_of_a_daemon() {
    let place = Place::new();
    let library = std::env::current_exe().unwrap().with_file_name("libgenomd_yarp.so");
    let server = place.options().server;
    // The example, but for where these two are.
    let example = std::fs::read_to_string(repository().join("configs/yarp.toml")).unwrap();
    let text = example
        .replace("\"../target/debug/libgenomd_yarp.so\"", &format!("{library:?}"))
        .replace("server = \"\"", &format!("server = {server:?}"));
    assert!(text.contains(path(&library)) && text.contains(&server), "{text}");
    let demo = component("demo").library;
    let daemon = Home::new().configured(&text).start(&["--path", path(demo.parent().unwrap())]);
    let told = asked(&place, "/demo/rpc", "set_speed 0.25\nget_speed\nset_speed 99\ngoto 0.01\n");
    assert!(told.contains("0.25") && told.contains("::demo::OUT_OF_RANGE"), "{told}");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.25\n");
    let reader = place.peer(&["read", "/reads", "/demo/position"]);
    // It has gone where it was sent.
    let position = reader.line("yarp read");
    assert!(position.starts_with("0.01"), "{position}");
    let names = place.prints(&["name", "list"]);
    assert!(names.contains("/demo/position") && names.contains("/demo/rpc"), "{names}");
    // The process that speaks YARP is a gateway, and no component ends with it.
    let cells = daemon.json(&["cells"]);
    assert_eq!(cells["cells"][0]["name"], "gateway-yarp", "{cells}");
    daemon.stop("TERM").0.expect_code(0);
    assert_eq!(place.prints(&["name", "list"]).matches("/demo/").count(), 0);
}
