//! The simulated arm of `configs/sim-arm.toml`: MuJoCo, a controller in C, a planner in Python.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use genom_components::python;
use genom_tests::{Daemon, Home, component, path, program, repository};
use serde_json::Value;

use crate::control_plane::recording::{Recorder, read};

/// The library of the simulator, built once as docs/simulators.md says.
fn simulator() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let python = python::environment(&["mujoco-core==4.0.1"]).unwrap();
        let source = repository().join("components/sim");
        let output = component("servo").library.parent().unwrap().with_file_name("sim");
        let ran = |command: &mut Command| {
            let output = command.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        let packages = output.join("pkgconfig");
        ran(Command::new(python).arg(source.join("pkgconfig.py")).arg(&packages));
        let mut build = Command::new(program("genomctl"));
        build.arg("build").arg(&source).arg("--output").arg(&output);
        ran(build.env("PKG_CONFIG_PATH", &packages));
        output.join("sim.so")
    })
}

/// The deployment, with its components where the tests have them.
fn deployed(backend: &str) -> Daemon {
    let folder = simulator().parent().unwrap().parent().unwrap();
    let _ = component("planner");
    let text = fs::read_to_string(repository().join("configs/sim-arm.toml")).unwrap();
    let text = text
        .replace("\"../target/components/", &format!("\"{}/", path(folder)))
        .replace("components/sim/arm.xml", path(&repository().join("components/sim/arm.xml")));
    let options = ["--clock", "virtual", "--backend", backend];
    let daemon = Home::new().configured(&text).start(&options);
    assert_eq!(daemon.home().get("/ready?wait=30&deployed=true")["ready"], true);
    daemon
}

/// What the simulator and the controller published in 1.2 s, in which the planner moves the arm.
fn motion(backend: &str) -> [Value; 3] {
    let daemon = deployed(backend);
    let recorder = Recorder::start(&daemon, "run.mcap", &["sim", "servo"]);
    daemon.ctl(&["start", "planner", "move", "goal=[0.5, 0.4, -0.8]", "duration=1"]).expect_code(0);
    // From the end of one period of the planner to the next: its cell is stepped first.
    for _ in 0..120 {
        daemon.ctl(&["step", "10ms"]).expect_code(0);
    }
    let (_, file) = recorder.end();
    let topics = read(&file);
    ["/sim/joints", "/sim/sensors", "/servo/command"].map(|topic| topics[topic].clone())
}

#[test]
fn a_simulated_arm_moves_to_its_goal_and_runs_are_equal_to_the_bit_on_local_and_shm() {
    let first = motion("local");
    let joints = first[0].as_array().unwrap();
    assert_eq!(joints.len(), 1200, "one a millisecond");
    let last = &joints.last().unwrap()[2]["position"];
    for (at, goal) in [0.5, 0.4, -0.8].iter().enumerate() {
        let came = last[at].as_f64().unwrap();
        assert!((came - goal).abs() < 0.02, "{last}");
    }
    assert!(first == motion("local"), "two runs differ");
    assert!(first == motion("shm"), "a run on shm differs");
}

#[test]
fn a_model_that_cannot_be_simulated_is_refused_with_the_reason() {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = scratch.path().join(name);
        fs::write(&file, text).unwrap();
        file
    };
    let daemon = Daemon::start(&[path(simulator())]);
    let simulate = |model: &Path| {
        let model = format!("model={}", path(model));
        let called = daemon.ctl(&["call", "sim", "simulate", &model]);
        called.expect_code(1);
        called.err
    };
    let none = simulate(&scratch.path().join("none.xml"));
    assert!(none.contains("::sim::NO_MODEL") && none.contains("none.xml"), "{none}");
    let wrong = simulate(&write("wrong.xml", "<mujoco><worldbody><geom/></worldbody></mujoco>"));
    assert!(wrong.contains("::sim::NO_MODEL"), "{wrong}");
    let slow = write("slow.xml", "<mujoco><option timestep=\"0.0015\"/><worldbody/></mujoco>");
    let slow = simulate(&slow);
    assert!(slow.contains("0.0015 s does not divide a period of 0.001 s"), "{slow}");
}
