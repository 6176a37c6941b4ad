//! Middlewares in processes of their own: what ends them ends no component.

mod adopted;
mod besieged;
mod ended;
mod sandboxed;

use std::fs;
use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path, until};
use serde_json::Value;

/// The configuration of a daemon without gateways.
pub(super) const NONE: &str = "[gateways]\nof = []\n";

/// A daemon that reaches the middleware through a gateway, and a peer that does not.
struct Pair {
    near: Daemon,
    far: Daemon,
    gateway: String,
}

impl Pair {
    /// The demo on this side, the mission on the other one, connected both ways. `more` is added to
    /// the configuration, `of_demo` to the command that loads the demo.
    fn new(backend: &str, more: &str, of_demo: &[&str]) -> Self {
        let memory = Arc::new(Memory::new());
        let homes = [more, NONE].map(|text| Home::with(&memory).configured(text));
        Self::of(homes, backend, of_demo)
    }

    /// The same on ROS 2 over zenoh.
    fn over_zenoh(more: &str, of_demo: &[&str]) -> Self {
        let memory = Arc::new(Memory::new());
        Self::of([more, NONE].map(|text| over_zenoh(&memory, text)), "ros2", of_demo)
    }

    fn of([near, far]: [Home; 2], backend: &str, of_demo: &[&str]) -> Self {
        let near = near.start(&["--backend", backend]);
        let demo = component("demo").library;
        near.ctl(&[&["load", path(&demo)], of_demo].concat()).expect_code(0);
        let mission = component("mission").library;
        let far = far.start(&["--backend", backend, path(&mission)]);
        far.ctl(&["connect", "mission/position", "demo/position"]).expect_code(0);
        far.ctl(&["connect", "mission/goto", "demo/goto"]).expect_code(0);
        near.ctl(&["connect", "demo/parameter", "mission/gain"]).expect_code(0);
        Self { near, far, gateway: format!("gateway-{backend}") }
    }

    /// Starts a motion that lasts.
    fn moves(&self) {
        self.near.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
        self.near.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    }

    /// Waits until the peer gets positions that it did not have.
    fn flows(&self) {
        let seen = || self.far.port("mission", "position")["value"].clone();
        let before = seen();
        until("the peer gets new positions", || seen() != before);
    }

    /// Sends a signal to the process of the gateway.
    fn signal(&self, signal: &str) {
        let pid = &gateway(&self.near, &self.gateway)["pid"];
        assert!(genom_tests::signal(pid, signal), "there is no process {pid}");
    }
}

/// A home whose ROS 2 is over zenoh, with a router that only those of this memory meet at.
fn over_zenoh(memory: &Arc<Memory>, text: &str) -> Home {
    let home = Home::with(memory).configured(text);
    let file = home.path().join("genomd.toml");
    let router = format!("unixsock-stream/{}", memory.root().join("router").display());
    let section = "[backends.ros2]\n";
    let zenoh = format!("{section}rmw = \"zenoh\"\nzenoh = {{ connect = [{router:?}] }}\n");
    let own = fs::read_to_string(&file).expect("the file was written");
    fs::write(file, own.replace(section, &zenoh)).expect("a file can be written");
    home
}

/// A gateway, as the daemon tells it.
#[track_caller]
fn gateway(daemon: &Daemon, name: &str) -> Value {
    let all = daemon.json(&["cells"]);
    let mut all = all["cells"].as_array().expect("cells").iter();
    all.find(|cell| cell["name"] == name).expect("the gateway").clone()
}

/// Number of ticks of the demo's task.
fn ticks(daemon: &Daemon) -> u64 {
    let told = daemon.json(&["stats", "demo"]);
    let tasks = told["tasks"].as_array().expect("tasks");
    tasks.iter().map(|task| task["cycles"]["count"].as_u64().expect("a number")).sum()
}
