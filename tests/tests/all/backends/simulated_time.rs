//! `clock = "ros"`: time of components is what a simulator publishes on `/clock`.

use genom_components::peer::Peer;
use genom_components::ros2;
use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::{Value, json};

use super::cdr::{CLOCK, date as date_in_cdr};
use super::zenoh_node::Node;

/// Time of components, in nanoseconds.
fn now(daemon: &Daemon) -> u64 {
    let clock = daemon.home().get("/clock");
    assert_eq!(clock["clock"], "ros");
    clock["now"].as_u64().expect("a date")
}

fn position(daemon: &Daemon) -> f64 {
    daemon.port("demo", "position")["value"]["position"].as_f64().expect("a position")
}

/// Passes of the demo's only task.
fn passes(daemon: &Daemon) -> u64 {
    let tasks = daemon.json(&["stats", "demo"]);
    tasks["tasks"][0]["cycles"]["count"].as_u64().unwrap_or_else(|| panic!("{tasks}"))
}

fn date(sec: i64, nanosec: u64) -> Value {
    json!(["put", "/clock", {"clock": {"sec": sec, "nanosec": nanosec}}])
}

/// The node of the demo says so when it is asked, and when it is to be another time.
fn says_that_its_time_is_simulated(daemon: &Daemon, peer: &mut Peer) {
    let namespace = daemon.home().memory().prefix().trim_end_matches('_').to_owned();
    let node = format!("/{namespace}/demo");
    peer.ask(&json!(["parameters", node]));
    assert_eq!(peer.ask(&json!(["get", node, ["use_sim_time"]])), json!([true]));
    let wanted = json!([["use_sim_time", true], ["use_sim_time", false]]);
    let results = peer.ask(&json!(["set", node, wanted]));
    assert_eq!(results[0]["successful"], true);
    let why = results[1]["reason"].as_str().expect("a reason");
    assert!(why.contains("`genomd --clock monotonic`"), "{why}");
}

/// A daemon with the demo, and a node of ROS that publishes `/clock`.
struct World {
    daemon: Daemon,
    peer: Peer,
}

impl World {
    fn new(arguments: &[&str]) -> Self {
        let home = Home::new();
        let mut node = ros2::node(home.memory().domain(), None).unwrap();
        let demo = component("demo");
        let arguments = [&["--clock", "ros"], arguments, &[path(&demo.library)]].concat();
        let daemon = home.start(&arguments);
        let mut peer = Peer::start(&mut node);
        peer.ask(&json!(["write", "/clock", "rosgraph_msgs/msg/Clock"]));
        Self { daemon, peer }
    }

    /// The simulator is at a date, and the log says so. It repeats the date, since one may be lost.
    fn tells(&mut self, sec: i64, nanosec: u64, what: &str) {
        until(what, || {
            self.peer.ask(&date(sec, nanosec));
            self.daemon.ctl(&["logs"]).out.contains(what)
        });
    }

    /// The simulator is at a date, and components at `wanted` nanoseconds.
    fn reaches(&mut self, sec: i64, nanosec: u64, wanted: u64) {
        until(&format!("the time of components is {wanted} ns"), || {
            self.peer.ask(&date(sec, nanosec));
            now(&self.daemon) == wanted
        });
    }
}

#[test]
fn components_live_in_the_time_of_a_simulator() {
    let mut world = World::new(&[]);
    world.daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    // Where the simulator begins is where they are.
    world.tells(1000, 0, "the time on /clock is 1000.000 s");
    world.reaches(1000, 50_000_000, 50_000_000);
    let first = position(&world.daemon);
    assert!(first > 0.0 && first < 0.5, "{first}");
    world.reaches(1005, 50_000_000, 5_050_000_000);
    assert_eq!(position(&world.daemon), 0.5);

    // The simulation is started again, and jumps.
    world.tells(3, 0, "the time on /clock was set back by 1002.05s");
    world.reaches(3, 1_000_000, 5_051_000_000);
    world.tells(90_000, 0, "the time on /clock jumped ahead by 89996.999s");
    world.reaches(90_000, 1_000_000, 5_052_000_000);
}

#[test]
fn components_in_cells_live_in_that_time_too() {
    let mut world = World::new(&["--isolated"]);
    let before = passes(&world.daemon);
    world.tells(0, 0, "the time on /clock is 0.000 s");
    world.reaches(0, 500_000_000, 500_000_000);
    // Its period is 5 ms.
    assert_eq!(passes(&world.daemon) - before, 100);
}

#[test]
fn nodes_say_in_use_sim_time_that_their_time_is_simulated_in_cells_and_without_gateways_too() {
    for options in [&[][..], &["--isolated"], &["--isolated", "--set", "gateways.of=[]"]] {
        let options = [&["--backend", "ros2"], options].concat();
        let World { daemon, mut peer } = World::new(&options);
        says_that_its_time_is_simulated(&daemon, &mut peer);
    }
}

#[test]
fn what_is_no_date_is_left_out_and_only_the_simulator_steps_that_clock() {
    let mut world = World::new(&[]);
    world.tells(7, 0, "the time on /clock is 7.000 s");
    world.tells(7, 1_000_000_000, "is no date: `sec` from 0, `nanosec` below 1000000000");
    for (sec, nanosec) in [(-1, 0), (i64::from(i32::MIN), 4_294_967_295)] {
        world.peer.ask(&date(sec, nanosec));
    }
    world.reaches(7, 1, 1);

    let daemon = &world.daemon;
    let refused = daemon.ctl(&["step", "10ms"]);
    refused.expect_code(1).expect_err("the clock of this daemon follows /clock of ROS 2");
    let reply = request(&daemon.home().socket(), "POST", "/clock", r#"{"nanoseconds": 1000}"#);
    assert_eq!((reply.status, reply.code()), (409, "clock_follows"));
    assert_eq!(now(daemon), 1);
}

#[test]
fn a_simulator_is_followed_over_zenoh_as_well() {
    let mut node = Node::start();
    let demo = component("demo");
    let daemon = node.daemon(Home::new(), &[], &["--clock", "ros", path(&demo.library)]);
    let peer = &mut node.peer;
    let [ty, hash] = CLOCK;
    peer.ask(&json!(["write", "/clock", ty, hash, false]));
    let mut milliseconds = 0_u32;
    // Nobody tells when the publisher is known to the daemon.
    until("time passes", || {
        milliseconds += 1;
        peer.ask(&json!(["put", "/clock", date_in_cdr(milliseconds)]));
        now(&daemon) > 0
    });
    assert_eq!(now(&daemon) % 1_000_000, 0);
}
