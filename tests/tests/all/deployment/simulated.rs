//! The simulated arm of `configs/sim-arm.toml`: MuJoCo, a controller in C, a planner in Python.

use std::collections::BTreeSet;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use genom_tests::python_client::python;
use genom_tests::{Daemon, Home, Running, WATCHDOG, component, path, program, repository, until};
use image::AnimationDecoder as _;
use image::codecs::png::PngDecoder;
use serde_json::Value;

use crate::control_plane::recording::{Recorder, raw, read};

/// The library of the simulator, built once as docs/simulators.md says.
pub(super) fn simulator() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let python = genom_components::python::environment(&["mujoco-core==4.0.1"]).unwrap();
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

/// A deployment of `configs`, with its components where the tests have them.
pub(super) fn deployment(file: &str, controllers: &[&str]) -> String {
    let folder = simulator().parent().unwrap().parent().unwrap();
    for controller in controllers {
        let _ = component(controller);
    }
    let text = fs::read_to_string(repository().join("configs").join(file)).unwrap();
    text.replace("\"../target/components/", &format!("\"{}/", path(folder)))
        .replace("\"components/sim/", &format!("\"{}/", path(&repository().join("components/sim"))))
}

/// A daemon with all that a deployment has.
pub(super) fn deployed(text: &str, options: &[&str]) -> Daemon {
    let daemon = Home::new().configured(text).start(options);
    assert_eq!(daemon.home().get("/ready?wait=30&deployed=true")["ready"], true);
    daemon
}

/// How far the joints are from a posture, rad.
fn distance(joints: &Value, goal: &[f64]) -> f64 {
    let position = joints["position"].as_array().map_or(&[][..], Vec::as_slice);
    if position.len() != goal.len() {
        return f64::INFINITY;
    }
    let each = position.iter().zip(goal).map(|(came, goal)| (came.as_f64().unwrap() - goal).abs());
    each.fold(0.0, f64::max)
}

/// A recording of all components in 1.2 s, in which the planner moves the arm and a camera sees it.
fn motion(backend: &str) -> (Daemon, PathBuf) {
    let text = deployment("sim-arm.toml", &["servo", "planner"]);
    let daemon = deployed(&text, &["--clock", "virtual", "--backend", backend]);
    let camera = ["camera=front", "width=32", "height=24", "every=100"];
    daemon.ctl(&[&["start", "sim", "watch"], &camera[..]].concat()).expect_code(0);
    let recorder = Recorder::start(&daemon, "run.mcap", &[]);
    daemon.ctl(&["start", "planner", "move", "goal=[0.5, 0.4, -0.8]", "duration=1"]).expect_code(0);
    // From the end of one period of the planner to the next: its cell is stepped first.
    for _ in 0..120 {
        daemon.ctl(&["step", "10ms"]).expect_code(0);
    }
    let (_, file) = recorder.end();
    (daemon, file)
}

/// Fails with the first message that two recordings do not have in common.
#[track_caller]
fn assert_same_bytes(first: &Value, other: &Value) {
    let (first, other) = (first.as_object().unwrap(), other.as_object().unwrap());
    let topics = |of: &serde_json::Map<String, Value>| of.keys().cloned().collect::<BTreeSet<_>>();
    assert_eq!(topics(first), topics(other), "topics");
    for (topic, one) in first {
        let other = &other[topic];
        assert_eq!(one["head"], other["head"], "type of {topic}");
        let messages = |of: &Value| of["messages"].as_array().unwrap().clone();
        let (one, other) = (messages(one), messages(other));
        for (rank, (one, other)) in one.iter().zip(&other).enumerate() {
            assert_eq!(one, other, "message {rank} of {topic}");
        }
        assert_eq!(one.len(), other.len(), "messages of {topic}");
    }
}

#[test]
fn a_simulated_arm_moves_to_its_goal_and_runs_are_equal_to_the_bit_on_local_and_shm() {
    let (_first, file) = motion("local");
    let topics = read(&file);
    let joints = topics["/sim/joints"].as_array().unwrap();
    assert_eq!(joints.len(), 1200, "one a millisecond");
    let last = &joints.last().unwrap()[2];
    assert!(distance(last, &[0.5, 0.4, -0.8]) < 0.02, "{last}");
    let targets = topics["/planner/target"].as_array().unwrap();
    assert_eq!(targets.len(), 100, "one each 10 ms for a second");
    assert!(distance(&targets[99][2], &[0.5, 0.4, -0.8]) == 0.0, "{}", targets[99]);
    for camera in ["/sim/image/front", "/sim/depth/front"] {
        let images = topics[camera].as_array().unwrap();
        assert_eq!(images.len(), 13, "one each 100 ms");
        assert_ne!(images[0][2]["data"], images[12][2]["data"], "the arm is seen to move");
    }
    let first = raw(&file);
    for backend in ["local", "shm"] {
        let (_again, file) = motion(backend);
        assert_same_bytes(&first, &raw(&file));
    }
}

#[test]
fn the_same_deployment_moves_the_arm_in_real_time_on_zenoh() {
    let text = deployment("sim-arm.toml", &["servo", "planner"]);
    let daemon = deployed(&text, &["--backend", "zenoh"]);
    assert_eq!(daemon.port("sim", "joints")["backend"], "zenoh");
    let goal = "goal=[0.5, 0.4, -0.8]";
    daemon.ctl(&["call", "planner", "move", goal, "duration=0.5"]).expect_code(0);
    until("the joints are where the planner wants them", || {
        distance(&daemon.port("sim", "joints")["value"], &[0.5, 0.4, -0.8]) < 0.02
    });
}

#[test]
fn the_example_writes_a_film_and_a_recording_of_the_arm_that_moves() {
    let scratch = tempfile::tempdir().unwrap();
    let file = |name: &str| scratch.path().join(name);
    let (config, film, recording) = (file("arm.toml"), file("arm.png"), file("arm.mcap"));
    fs::write(&config, deployment("sim-arm.toml", &["servo", "planner"])).unwrap();
    let mut example = Command::new(python());
    example
        .arg(repository().join("components/sim/run.py"))
        .arg("--config")
        .arg(&config)
        .arg("--film")
        .arg(&film)
        .arg("--record")
        .arg(&recording)
        .env("PYTHONPATH", repository().join("clients/python/src"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("GENOMD", program("genomd"))
        .env("GENOMCTL", program("genomctl"))
        .env("XDG_STATE_HOME", scratch.path().join("state"))
        .env("TMPDIR", scratch.path());
    let finished = Running::start(&mut example).finish_within(3 * WATCHDOG);
    finished.expect_code(0);
    for told in [" images in ", "/planner/target", " seconds of the arm in a second"] {
        assert!(finished.out.contains(told), "{}", finished.out);
    }

    let decoder = PngDecoder::new(Cursor::new(fs::read(&film).unwrap())).unwrap();
    let frames = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
    assert!(frames.len() >= 75, "{} images in at least 3 s", frames.len());
    assert_eq!(frames[0].buffer().dimensions(), (160, 120));
    assert!(frames[0].buffer() != frames[25].buffer(), "the arm is seen to move");

    // The simulator, the controller, and the planner in its own process.
    let topics = read(&recording);
    let of = |topic: &str| topics[topic].as_array().unwrap_or_else(|| panic!("no {topic}"));
    for topic in ["/sim/joints", "/sim/sensors", "/servo/command", "/servo/target"] {
        assert!(!of(topic).is_empty(), "{topic}");
    }
    let targets = of("/planner/target");
    assert_eq!(targets.len(), 300, "three motions of 1 s");
    for (rank, goal) in [(99, [0.5, 0.4, -0.8]), (199, [-0.5, 0.8, -1.2]), (299, [0.0; 3])] {
        assert!(distance(&targets[rank][2], &goal) == 0.0, "{}", targets[rank]);
    }
    let lost = topics["metadata"]["genom.lost"]["/sim/joints"].as_str().unwrap();
    let all = of("/sim/joints").len() + lost.parse::<usize>().unwrap();
    assert!(all >= 3000, "{all} samples in 3 s, one a millisecond");
    assert!(distance(&of("/sim/joints").last().unwrap()[2], &[0.0; 3]) < 0.02);
    assert_eq!(topics["metadata"]["genom.lost"]["complete"], "true");
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
