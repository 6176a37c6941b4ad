//! Several middlewares in one daemon, and components that move between them while running.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use genom_tests::{Counts, Daemon, Home, Memory, WATCHDOG, component, path, step};
use serde_json::Value;

/// A daemon with the paper's component, which publishes a double, and the demo, which reads one.
fn both(backend: &str, clock: &str) -> Daemon {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let daemon = Daemon::start(&["--clock", clock, "--backend", backend, path(&demo.library)]);
    daemon.ctl(&["load", path(&paper.description), "--name", "paper"]).expect_code(0);
    daemon.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    daemon
}

/// What the demo reads after the paper's component went to `position`.
fn read_after_goto(daemon: &Daemon, position: &str, goal: &str) -> Value {
    daemon.ctl(&["call", "paper", "goto", &format!("position={position}")]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", &format!("goal={goal}")]).expect_code(0);
    daemon.port("demo", "parameter")["value"].clone()
}

#[test]
fn a_running_component_moves_and_what_it_feeds_follows() {
    let daemon = both("local", "monotonic");
    assert_eq!(read_after_goto(&daemon, "0.125", "0.01"), 0.125);
    for (backend, position, goal) in
        [("shm", "0.25", "0.02"), ("zenoh", "0.375", "0.03"), ("local", "0.5", "0.04")]
    {
        let moved = daemon.ctl(&["backend", "paper", backend]);
        moved.expect_code(0).expect_out(&format!("paper is on {backend}\n"));
        let connections = daemon.json(&["connections"]);
        assert_eq!(connections["connections"][0]["backend"], backend);
        assert_eq!(read_after_goto(&daemon, position, goal).to_string(), position);
    }
    let refused = daemon.ctl(&["backend", "paper", "zeno"]);
    refused.expect_code(1).expect_err("did you mean `zenoh`?");
    daemon.ctl(&["backend", "paper/positon", "shm"]).expect_code(1).expect_err("`position`?");
}

#[test]
fn a_move_in_the_middle_of_a_motion_misses_no_tick() {
    let demo = component("demo");
    // A period that a busy machine does not exceed, but opening a middleware would.
    let config = format!(
        "backend = \"shm\"\n[[component]]\nlibrary = {:?}\ntasks = {{ main = {{ period_ms = 100 }} }}\n",
        demo.library
    );
    let daemon = Home::new().configured(&config).start(&[]);
    let paper = component("demo-2010");
    daemon.ctl(&["load", path(&paper.description), "--name", "paper"]).expect_code(0);
    daemon.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=0.12"]);
    events.wait_for(|event| event["event"] == "transition" && event["state"] == "main");
    for round in 0..6 {
        let to = ["shm+zenoh", "zenoh", "shm"][round % 3];
        daemon.ctl(&["backend", "demo", to]).expect_code(0);
        daemon.ctl(&["backend", "paper", to]).expect_code(0);
    }
    let running = daemon.json(&["activities", "demo"])["activities"][0]["status"].clone();
    assert_eq!(running, "running", "the motion ended before the moves did");
    waiting.finish().expect_code(0);
    let after = daemon.json(&["stats", "demo"])["tasks"][0].clone();
    // Ticks missed because the machine was busy do not count: a move causes missed ticks only if
    // the tick before took longer than the period.
    let period = after["period_ns"].as_u64().unwrap();
    assert!(after["cycles"]["max_ns"].as_u64().unwrap() < period, "{after}");
    assert!(after["cycles"]["count"].as_u64().unwrap() > 40, "{after}");
}

/// Both components run without end: the paper's moves away from 0, and the demo does not move,
/// because the gain that it reads is below 0.
fn both_under_way() -> Daemon {
    let daemon = both("local", "virtual");
    daemon.ctl(&["start", "paper", "goto", "position=-1e9"]).expect_code(0);
    daemon.step(20);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    daemon.step(20);
    daemon
}

/// What a move could affect: counters and positions of both.
fn state_of(daemon: &Daemon) -> [(Counts, Value); 2] {
    ["paper", "demo"].map(|name| {
        let counts = daemon.counts(name, "demo_servo", "position");
        // Steps follow each other faster than a network accepts samples.
        (Counts { dropped: 0, ..counts }, daemon.port(name, "position")["value"].clone())
    })
}

#[test]
fn moves_through_every_middleware_cost_no_tick_and_no_codel_notices() {
    let daemon = both_under_way();
    let socket = daemon.home().socket();
    let (ticks, enough) = (AtomicU64::new(0), AtomicBool::new(false));
    let parameter = || daemon.port("demo", "parameter")["value"].as_f64().unwrap();
    let position = || daemon.port("paper", "position")["value"].as_f64().unwrap();
    thread::scope(|scope| {
        // Time advances meanwhile.
        scope.spawn(|| {
            while !enough.load(Ordering::Relaxed) {
                step(&socket, 5);
                ticks.fetch_add(1, Ordering::Relaxed);
            }
        });
        let _end = End(&enough);
        for what in ["paper/position", "paper", "demo"] {
            for backend in ["shm", "zenoh", "ros2", "local"] {
                daemon.ctl(&["backend", what, backend]).expect_code(0);
                let written = position();
                let end = Instant::now() + WATCHDOG;
                while parameter() >= written {
                    assert!(Instant::now() < end, "{what} on {backend}: nothing arrives");
                }
            }
        }
    });
    let ticks = ticks.into_inner();
    assert!(ticks > 0);
    let still = both_under_way();
    still.step(5 * ticks);
    let moved = state_of(&daemon);
    assert_eq!(moved, state_of(&still), "after {ticks} ticks, moved and not");
    assert!(moved.iter().all(|(all, _)| all.runs >= ticks && all.missed + all.failed == 0));
}

struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn one_out_port_on_two_middlewares_feeds_readers_on_both() {
    let memory = Arc::new(Memory::new());
    let (writer, reader) = (component("demo-2010"), component("demo"));
    let mut config = String::from("backend = \"shm\"\n");
    config
        .push_str("[[component]]\nname = \"paper\"\nports = { position = [\"shm\", \"zenoh\"] }\n");
    config.push_str(&format!("library = {:?}\n", writer.description));
    let writer = Home::with(&memory).configured(&config).start(&[]);
    for (backend, name, position, value) in
        [("shm", "one", "0.25", 0.25), ("zenoh", "two", "0.5", 0.5)]
    {
        let reader = Home::with(&memory).start(&[
            "--backend",
            backend,
            "--name",
            name,
            path(&reader.library),
        ]);
        let inport = format!("{name}/parameter");
        // The in port's own middleware is the default, and any can be named.
        for outport in ["paper/position".to_owned(), format!("{backend}:paper/position")] {
            let made = reader.ctl(&["connect", &inport, &outport, "--wait"]);
            made.expect_code(0);
            made.expect_out(&format!("{inport} reads paper/position ({backend}, latest)\n"));
        }
        writer.ctl(&["call", "paper", "goto", &format!("position={position}")]).expect_code(0);
        let arrived = || {
            reader.ctl(&["call", name, "goto", "goal=0.01"]).expect_code(0);
            reader.ctl(&["call", name, "goto", "goal=0"]).expect_code(0);
            reader.port(name, "parameter")["value"].clone()
        };
        assert_eq!(arrived(), value, "{backend}");
    }
    let shown = writer.json(&["info", "paper"]);
    assert_eq!(shown["port_backends"]["position"], "shm+zenoh");
}
