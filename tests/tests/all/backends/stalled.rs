//! What still works if the network of a running daemon stalls, or a daemon's process is stopped.
//!
//! The daemon runs with `fixtures/stall` preloaded: while this test locks a file, every thread that
//! sends a datagram blocks. The daemon does not know about it.

use std::fs::File;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use genom_tests::{Counts, Daemon, Home, Memory, Running, component, path, repository, until};
use serde_json::Value;

/// Period of the writer's task.
const PERIOD: u64 = 1;

/// More samples than DDS and the daemon together keep for a reader.
const MANY: u64 = 3000;

/// The paper's component on ROS 2, which writes in each tick of its motion, and another daemon
/// whose demo reads it.
struct World {
    writer: Daemon,
    reader: Daemon,
    /// Locked while the network stalls.
    gate: PathBuf,
}

impl World {
    fn new(clock: &str) -> Self {
        let memory = Arc::new(Memory::new());
        let (paper, demo) = (component("demo-2010"), component("demo"));
        let config = format!(
            "backend = \"ros2\"\n[[component]]\nlibrary = {:?}\nname = \"paper\"\n\
             [component.tasks.main]\nperiod_ms = {PERIOD}.0\n",
            paper.description
        );
        let home = Home::with(&memory).configured(&config);
        let (gate, stall) = (home.path().join("gate"), home.path().join("stall.so"));
        File::create(&gate).unwrap();
        let mut compiler = Command::new("cc");
        compiler.args(["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]);
        compiler.arg(repository().join("tests/fixtures/stall/stall.c"));
        compiler.arg("-o").arg(&stall).arg("-ldl");
        Running::start(&mut compiler).finish().expect_code(0);
        let preload = format!("LD_PRELOAD={}", path(&stall));
        let lock = format!("STALL={}", path(&gate));
        let writer = home.start_by(&["env", &preload, &lock], &["--clock", clock]);
        let reader = Home::with(&memory).start(&["--backend", "ros2", path(&demo.library)]);
        let connect = ["connect", "demo/parameter", "paper/position", "--wait"];
        reader.ctl(&connect).expect_code(0);
        // Both run without end: the demo does not move while it reads a value below 0.
        writer.ctl(&["start", "paper", "goto", "position=-1e9"]).expect_code(0);
        reader.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
        reader.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
        Self { writer, reader, gate }
    }

    /// Stalls the network until the result is dropped: from now on no datagram is sent.
    fn stall(&self) -> File {
        let gate = File::open(&self.gate).unwrap();
        gate.lock().unwrap();
        gate
    }

    fn counts(&self) -> Counts {
        self.writer.counts("paper", "demo_servo", "position")
    }

    fn sent(&self) -> Value {
        self.writer.port("paper", "position")["value"].clone()
    }

    fn read(&self) -> Value {
        self.reader.port("demo", "parameter")["value"].clone()
    }
}

#[test]
fn every_tick_is_run_while_the_network_stalls_and_what_is_given_up_is_counted() {
    let world = World::new("virtual");
    world.writer.step(20 * PERIOD);
    until("the last value arrives", || world.read() == world.sent());
    let (before, value) = (world.counts(), world.read());
    let stalled = world.stall();
    // A step ends after all its ticks have run; otherwise the test hangs here.
    (0..MANY / 100).for_each(|_| world.writer.step(100 * PERIOD));
    let after = world.counts();
    assert_eq!(world.read(), value, "something arrived");
    drop(stalled);
    assert_eq!(after.ticks - before.ticks, MANY);
    assert_eq!(after.runs - before.runs, MANY);
    assert_eq!(after.written - before.written, MANY);
    assert_eq!((after.missed, after.failed), (0, 0));
    assert!(after.dropped > before.dropped, "{after:?}");
    until("the newest value arrives", || world.read() == world.sent());
}

#[test]
fn a_task_keeps_its_pace_while_the_network_stalls() {
    let world = World::new("monotonic");
    // Null until it is read for the first time.
    let position = |value: &Value| value.as_f64().unwrap_or_default();
    until("values arrive", || position(&world.read()) < 0.0);
    let stalled = world.stall();
    let before = world.counts();
    until("the task goes on", || world.counts().runs - before.runs > MANY);
    until("what is given up is counted", || world.counts().dropped > before.dropped);
    let sent = world.sent();
    drop(stalled);
    assert_eq!(world.counts().failed, 0);
    until("newer values arrive", || position(&world.read()) < position(&sent));
}

#[test]
fn a_port_leaves_a_middleware_that_stalls_and_no_tick_waits_for_it() {
    let world = World::new("virtual");
    world.writer.step(20 * PERIOD);
    until("the last value arrives", || world.read() == world.sent());
    let before = world.counts();
    let stalled = world.stall();
    (0..MANY / 100).for_each(|_| world.writer.step(100 * PERIOD));
    let moving = world.writer.spawn(&["backend", "paper", "local"]);
    (0..MANY / 100).for_each(|_| world.writer.step(100 * PERIOD));
    drop(stalled);
    moving.finish().expect_code(0).expect_out("paper is on local\n");
    world.writer.step(PERIOD);
    let after = world.counts();
    assert_eq!(after.ticks - before.ticks, 2 * MANY + 1);
    assert_eq!(after.runs - before.runs, 2 * MANY + 1);
    assert_eq!(after.written - before.written, 2 * MANY + 1);
    assert_eq!((after.missed, after.failed), (0, 0));
}

#[test]
fn daemons_that_were_stopped_and_go_on_still_exchange_samples() {
    // As caused by Ctrl-Z and `fg`, a debugger, or system suspend: the waits of all threads are
    // interrupted.
    let world = World::new("virtual");
    world.writer.step(20 * PERIOD);
    until("the last value arrives", || world.read() == world.sent());
    for daemon in [&world.writer, &world.reader] {
        let status = format!("/proc/{}/status", daemon.process().id());
        let stopped = || std::fs::read_to_string(&status).unwrap().contains("State:\tT");
        daemon.process().signal("STOP");
        until("it stops", stopped);
        daemon.process().signal("CONT");
        until("it goes on", || !stopped());
    }
    world.writer.step(20 * PERIOD);
    until("the next value arrives", || world.read() == world.sent());
    world.writer.ctl(&["backend", "paper", "local"]).expect_code(0);
    world.writer.ctl(&["backend", "paper", "ros2"]).expect_code(0);
    world.writer.step(20 * PERIOD);
    until("a new writer is heard", || world.read() == world.sent());
}
