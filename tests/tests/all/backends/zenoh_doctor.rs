//! `genomctl doctor` says what keeps a daemon from others on zenoh, and why zenoh is not open.

use std::net::TcpListener;

use genom_tests::{Daemon, Home, component, path, until};

/// An address on this machine that no other test uses.
fn address(number: u8) -> String {
    let [_, _, b, c] = std::process::id().to_be_bytes();
    format!("127.{}.{b}.{c}:29449", 100 + number)
}

/// What the doctor finds of a middleware.
fn found(daemon: &Daemon, middleware: &str) -> Vec<String> {
    let told = daemon.ctl(&["--json", "doctor"]).out;
    let told: serde_json::Value = serde_json::from_str(&told).expect("findings");
    let all = told["findings"].as_array().expect("findings");
    let of = all.iter().filter(|one| one["about"] == middleware);
    of.map(|one| one["what"].as_str().expect("a text").to_owned()).collect()
}

#[test]
fn a_router_that_is_not_there_is_told_until_it_is() {
    let (first, second) = (address(1), address(2));
    let connect = format!("backends.zenoh.connect=[\"tcp/{first}\"]");
    let over_zenoh = format!("backends.ros2.zenoh.connect=[\"tcp/{second}\"]");
    let demo = component("demo");
    let daemon = Home::new().start(&[
        "--backend",
        "zenoh",
        "--set",
        &connect,
        "--set",
        "backends.ros2.rmw=\"zenoh\"",
        "--set",
        "backends.ros2.zenoh.router=false",
        "--set",
        &over_zenoh,
        path(&demo.library),
    ]);
    let load = ["load", path(&demo.library), "--name", "other", "--backend", "ros2"];
    daemon.ctl(&load).expect_code(0);
    for (middleware, address) in [("zenoh", first.as_str()), ("ros2", second.as_str())] {
        let told = found(&daemon, middleware);
        assert_eq!(told.len(), 1, "{told:?}");
        let begins = format!("there is no session with tcp/{address}, which is to be connected: ");
        assert!(told[0].starts_with(&begins) && told[0].contains("refused"), "{told:?}");
    }
    let printed = daemon.ctl(&["doctor"]);
    printed.expect_code(1);
    let line = format!("problem  zenoh: there is no session with tcp/{first}");
    assert!(printed.out.contains(&line), "{}", printed.out);
    let listen = format!("backends.zenoh.listen=[\"tcp/{first}\"]");
    let _router = Home::new().start(&["--backend", "zenoh", "--set", &listen]);
    until("the session is there", || found(&daemon, "zenoh").is_empty());
}

#[test]
fn a_port_that_is_taken_and_a_file_that_cannot_be_read_are_told_after_they_were_needed() {
    let address = address(3);
    let taken = TcpListener::bind(&address).expect("the address is free");
    let home = Home::new();
    let file = home.path().join("zenoh.json5");
    std::fs::write(&file, "{\n  mode: 'peer',\n  lisen: {}\n}\n").expect("a file");
    let wrong = format!("backends.zenoh.config={:?}", path(&file));
    let demo = component("demo");
    for (setting, why) in [
        (format!("backends.zenoh.listen=[\"tcp/{address}\"]"), "Address already in use"),
        (wrong, "zenoh.json5 is no zenoh configuration: line 3, column 3: unknown field `lisen`"),
    ] {
        let daemon = Home::new().start(&["--set", &setting, "--set", "gateways.of=[]"]);
        assert_eq!(found(&daemon, "zenoh"), [""; 0], "it was not needed yet");
        daemon.ctl(&["load", path(&demo.library), "--backend", "zenoh"]).expect_code(1);
        let told = found(&daemon, "zenoh");
        assert_eq!(told.len(), 1, "{told:?}");
        let begins = "it was needed and could not be opened: ";
        assert!(told[0].starts_with(begins) && told[0].contains(why), "{told:?}");
    }
    drop(taken);
}
