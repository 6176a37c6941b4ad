//! What foreign programs on a middleware can call, and what not.

use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path, until};

/// Services that are only for supervisors.
const SUPERVISORS: [&str; 4] = ["kill", "connect_port", "connect_service", "abort_activity"];

fn visible(daemon: &Daemon, backend: &str) -> String {
    let listed = daemon.json(&["backends", "--visible"]);
    let all = listed["middlewares"].as_array().expect("middlewares");
    let own = all.iter().find(|one| one["name"] == backend).expect("the backend");
    own["endpoints"].to_string()
}

#[test]
fn strangers_find_no_service_that_supervisors_need_a_right_for() {
    for backend in ["zenoh", "ros2"] {
        let memory = Arc::new(Memory::new());
        let demo = component("demo");
        let robot = Home::with(&memory).start(&["--backend", backend, path(&demo.library)]);
        // Another daemon is a foreign program, too: it sees what anybody sees.
        let other = Home::with(&memory).start(&["--backend", backend]);
        until("it sees the services", || visible(&other, backend).contains("demo/goto"));
        let seen = visible(&other, backend);
        for service in SUPERVISORS {
            assert!(!seen.contains(&format!("demo/{service}")), "{backend} {service}: {seen}");
            let described = robot.json(&["info", "demo", service]);
            assert_eq!(described["served"], serde_json::json!([]), "{described}");
            // They are available on the control plane.
            let called = robot.ctl(&["info", "demo", service]);
            called.expect_code(0);
        }
        assert_eq!(robot.json(&["info", "demo", "goto"])["served"], serde_json::json!([backend]));
        let told = robot.ctl(&["info", "demo"]);
        let line = format!("  {backend} has all services but ");
        let line = told.out.lines().find(|one| one.starts_with(&line)).expect("it is told");
        for service in SUPERVISORS {
            assert!(line.contains(service), "{line}");
        }
    }
}

#[test]
fn the_configuration_says_what_is_offered_where() {
    let memory = Arc::new(Memory::new());
    let demo = component("demo");
    let text = "[services]\nallow = [\"*/get_speed\", \"zenoh:demo/kill\", \"shm:*\"]\n\
                deny = [\"zenoh:other/*\"]\n";
    let home = Home::with(&memory).configured(text);
    let robot = home.start(&["--backend", "zenoh", path(&demo.library)]);
    let other = Home::with(&memory).start(&["--backend", "zenoh"]);
    let served = |component: &str, service: &str| {
        robot.json(&["info", component, service])["served"].clone()
    };
    assert_eq!(served("demo", "kill"), serde_json::json!(["zenoh"]));
    assert_eq!(served("demo", "goto"), serde_json::json!([]));
    until("it sees the service", || visible(&other, "zenoh").contains("demo/kill"));
    assert!(!visible(&other, "zenoh").contains("demo/goto"));
    // This also applies to components that are loaded later or move.
    robot.ctl(&["load", path(&demo.library), "--name", "other"]).expect_code(0);
    let told = robot.ctl(&["info", "other"]);
    assert!(told.expect_code(0).out.contains("\n  zenoh has no service\n"), "{}", told.out);
    robot.ctl(&["backend", "demo", "shm"]).expect_code(0);
    assert_eq!(served("demo", "goto"), serde_json::json!(["shm"]));
    robot.ctl(&["backend", "demo", "zenoh"]).expect_code(0);
    assert_eq!(served("demo", "goto"), serde_json::json!([]));
    let wrong = Home::new().configured("[services]\ndeny = [\"zenho:*\"]\n");
    wrong.refused(&[]).expect_code(2).expect_err("`zenho:*` is no pattern");
}

#[test]
fn zenoh_lets_nobody_in_from_the_network_unless_that_is_written_twice() {
    let refused = |home: &Home, listen: &str, what: &str| {
        let listen = format!("backends.zenoh.listen=[{listen:?}]");
        let refused = home.refused(&["--backend", "zenoh", "--set", &listen]);
        refused.expect_code(3).expect_err(what).expect_err("insecure = true");
    };
    for open in ["tcp/0.0.0.0:0", "tls/0.0.0.0:0", "udp/[::]:0"] {
        refused(&Home::new(), open, &format!("`{open}` lets in whoever reaches it"));
    }
    let set = "[backends.zenoh.set]\n\"scouting/multicast/enabled\" = true\n";
    refused(&Home::new().configured(set), "tcp/127.0.0.1:0", "scouting/multicast connects");
    let home = Home::new();
    let listen = "backends.zenoh.listen=[\"tcp/0.0.0.0:0\"]";
    let daemon = home.start(&[
        "--backend",
        "zenoh",
        "--set",
        listen,
        "--set",
        "backends.zenoh.insecure=true",
    ]);
    daemon.ctl(&["list"]).expect_code(0);
}
