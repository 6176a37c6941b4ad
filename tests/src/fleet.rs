//! Two daemons that share only zenoh, in them or in a library: a robot that requires tokens, and a
//! desk.

use std::process::Command;
use std::sync::Arc;

use crate::{Daemon, Finished, Home, Memory, Running, component, path, program};

/// A robot with the demo, and a desk without components; they share only zenoh.
#[must_use]
pub fn fleet() -> (Daemon, Daemon) {
    fleet_on("zenoh", "zenoh")
}

/// The middleware that is zenoh in a library of its own.
pub const IN_A_LIBRARY: &str = "zenoh_plugin";

/// A directory of a daemon on this middleware, which meets the others there.
fn home(memory: &Arc<Memory>, backend: &str) -> Home {
    let home = Home::with(memory);
    if backend == IN_A_LIBRARY { home.configured(&in_a_library(memory)) } else { home }
}

/// The section of that middleware: it meets those on zenoh with this memory.
#[must_use]
pub fn in_a_library(memory: &Memory) -> String {
    let library = program("genomd").with_file_name("libgenomd_zenoh_plugin.so");
    let meeting = memory.root().join("zenoh");
    format!("[backends.{IN_A_LIBRARY}]\nlibrary = {library:?}\nrendezvous = {meeting:?}\n")
}

/// The same fleet, with the robot and the desk on these middlewares.
#[must_use]
pub fn fleet_on(of_robot: &str, of_desk: &str) -> (Daemon, Daemon) {
    let memory = Arc::new(Memory::new());
    let robot = home(&memory, of_robot);
    for (name, rights) in [("watcher", "read"), ("driver", "read,call")] {
        for file in ["tokens.toml", name] {
            let mut command = Command::new(program("genomctl"));
            command.current_dir(robot.path()).args(["token", name, "--rights", rights]);
            let made = Running::start(command.args(["--into", file])).finish();
            made.expect_code(0);
        }
        let text = |file| std::fs::read_to_string(robot.path().join(file)).expect("as made");
        let all = text("tokens.toml");
        let others = &all[..all.rfind("[[token]]").expect("as made")];
        std::fs::write(robot.path().join("tokens.toml"), format!("{others}{}", text(name)))
            .expect("as made");
    }
    let demo = component("demo");
    let robot = robot.start(&[
        "--backend",
        of_robot,
        "--daemon",
        "robot",
        "--token-file",
        "tokens.toml",
        path(&demo.library),
    ]);
    let desk = home(&memory, of_desk).start(&["--backend", of_desk, "--daemon", "desk"]);
    (robot, desk)
}

/// Runs a `genomctl` through the desk's daemon for the robot's.
#[must_use]
pub fn at_the_robot(robot: &Daemon, desk: &Daemon, token: &str, arguments: &[&str]) -> Finished {
    let token = robot.home().path().join(token);
    desk.ctl(&[&["--host", "zenoh:robot", "--token-file", path(&token)], arguments].concat())
}
