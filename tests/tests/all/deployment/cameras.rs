//! Cameras of simulated robots (docs/simulators.md).

use std::fs;

use genom_tests::{Daemon, path};
use serde_json::{Value, json};

use super::simulated::simulator;

/// A red box of 60 cm, 50 cm high, on a green floor of 3 m; cameras are 2 m above the floor.
const MODEL: &str = r#"<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <geom type="plane" size="1.5 1.5 0.1" rgba="0 1 0 1"/>
    <geom type="box" size="0.3 0.3 0.25" pos="0 0 0.25" rgba="1 0 0 1"/>
    <camera name="down" pos="0 0 2" fovy="90"/>
    <camera name="up" pos="0 0 2" xyaxes="1 0 0 0 -1 0" fovy="90"/>
    <camera name="flat" pos="0 0 2" projection="orthographic" fovy="1"/>
  </worldbody>
</mujoco>"#;

/// The simulator with that model, before its first step.
fn simulated() -> Daemon {
    let daemon = Daemon::start(&["--clock", "virtual", path(simulator())]);
    let model = daemon.home().path().join("cameras.xml");
    fs::write(&model, MODEL).unwrap();
    let model = format!("model={}", path(&model));
    daemon.ctl(&["start", "sim", "simulate", &model]).expect_code(0);
    daemon
}

/// The last image of a port.
fn taken(daemon: &Daemon, address: &str) -> Value {
    let reply = daemon.json(&["ports", "sim"]);
    let ports = reply["ports"].as_array().unwrap();
    ports.iter().find(|port| port["address"] == address).expect(address)["value"].clone()
}

/// Its depths, mm.
fn depths(image: &Value) -> Vec<u64> {
    let bytes: Vec<_> = image["data"].as_array().unwrap().iter().flat_map(Value::as_u64).collect();
    bytes.chunks(2).map(|two| two[0] + 256 * two[1]).collect()
}

#[test]
fn cameras_measure_depths_to_the_millimetre_and_see_colours_and_the_sky() {
    let daemon = simulated();
    for camera in ["camera=down", "camera=up"] {
        let small = ["width=3", "height=3", "every=10", "images=1"];
        daemon.ctl(&[&["start", "sim", "watch", camera], &small[..]].concat()).expect_code(0);
    }
    daemon.ctl(&["step", "30ms"]).expect_code(0);

    let depth = taken(&daemon, "sim/depth/down");
    // Before the plane of the camera, not along the ray: the floor is as far everywhere.
    let floor = 2000;
    assert_eq!(depths(&depth), [floor, floor, floor, floor, 1500, floor, floor, floor, floor]);
    let image = taken(&daemon, "sim/image/down");
    assert_eq!(image["stamp"], depth["stamp"]);
    for (image, encoding, step) in [(&image, "rgb8", 9), (&depth, "16UC1", 6)] {
        let told = ["frame_id", "encoding", "width", "height", "step"].map(|key| &image[key]);
        assert_eq!(json!(told), json!(["down", encoding, 3, 3, step]));
    }
    assert_eq!(image["data"].as_array().unwrap()[12..15], [json!(255), json!(0), json!(0)]);
    let corner = &image["data"].as_array().unwrap()[..3];
    assert!(corner[0] == 0 && corner[1].as_u64() > Some(150) && corner[2] == 0, "{corner:?}");

    assert_eq!(depths(&taken(&daemon, "sim/depth/up")), [0; 9]);
    let sky = taken(&daemon, "sim/image/up");
    assert_eq!(sky["data"], json!([140, 173, 209].repeat(9)));
}

#[test]
fn a_camera_that_cannot_be_drawn_is_refused_with_the_reason() {
    let daemon = simulated();
    let refused = |arguments: &[&str]| {
        let started = daemon.json(&[&["start", "sim", "watch"], arguments].concat());
        daemon.ctl(&["step", "20ms"]).expect_code(0);
        let reply = daemon.json(&["activities", "sim"]);
        let activities = reply["activities"].as_array().unwrap();
        let ended = activities.iter().find(|one| one["activity"] == started["activity"]).unwrap();
        assert_eq!(ended["exception"], "::sim::NO_CAMERA", "{ended}");
        ended["detail"]["why"].as_str().unwrap().to_owned()
    };
    assert_eq!(refused(&["camera=none"]), "none: the model has no such camera");
    assert_eq!(refused(&["camera=flat"]), "flat: only cameras with perspective are drawn");
    assert_eq!(refused(&["camera="]), "\"\": a camera needs a name in the model");
    let size = "down: an image has from 1 to 102400 pixels";
    for wrong in
        [["width=0", "height=3"], ["width=102401", "height=1"], ["width=65536", "height=65536"]]
    {
        assert_eq!(refused(&[&["camera=down"], &wrong[..]].concat()), size);
    }
    for every in ["every=0", "every=15"] {
        let why = "down: images are taken every 10 ms, 20 ms, ...";
        assert_eq!(refused(&["camera=down", every]), why);
    }
    // The simulation goes on.
    let before = daemon.port("sim", "joints")["traffic"]["samples"].as_u64();
    daemon.ctl(&["step", "10ms"]).expect_code(0);
    assert_eq!(daemon.port("sim", "joints")["traffic"]["samples"].as_u64(), before.map(|n| n + 10));
}
