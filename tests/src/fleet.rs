//! Two daemons that share only zenoh: a robot that requires tokens, and a desk.

use std::process::Command;
use std::sync::Arc;

use crate::{Daemon, Finished, Home, Memory, Running, component, path, program};

/// A robot with the demo, and a desk without components; they share only zenoh.
#[must_use]
pub fn fleet() -> (Daemon, Daemon) {
    let memory = Arc::new(Memory::new());
    let robot = Home::with(&memory);
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
        "zenoh",
        "--daemon",
        "robot",
        "--token-file",
        "tokens.toml",
        path(&demo.library),
    ]);
    let desk = Home::with(&memory).start(&["--backend", "zenoh", "--daemon", "desk"]);
    (robot, desk)
}

/// Runs a `genomctl` through the desk's daemon for the robot's.
#[must_use]
pub fn at_the_robot(robot: &Daemon, desk: &Daemon, token: &str, arguments: &[&str]) -> Finished {
    let token = robot.home().path().join(token);
    desk.ctl(&[&["--host", "zenoh:robot", "--token-file", path(&token)], arguments].concat())
}
