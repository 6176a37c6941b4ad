//! Requests and images that the components of the vision pipeline do not take.

use genom_tests::{Daemon, component, path};
use serde_json::{Value, json};

fn frame((width, height): (u32, u32), encoding: &str, bytes: usize) -> Value {
    json!({
        "stamp": {"sec": 0, "nanosec": 0}, "frame_id": "left", "height": height, "width": width,
        "encoding": encoding, "is_bigendian": 0, "step": width, "data": vec![7; bytes],
    })
}

/// What `correlate` ends with, for a rig of 8 x 4 pixels, and these images.
fn compared(daemon: &Daemon, left: &Value, right: &Value) -> genom_tests::Finished {
    let lens = json!({"focal": 5.0, "cx": 3.5, "cy": 1.5, "k1": 0.0, "k2": 0.0});
    let rig = json!({"height": 4, "width": 8, "left": lens, "right": lens, "baseline": 0.1});
    for (port, value) in [("left", left), ("right", right), ("calibration", &rig)] {
        daemon.ctl(&["pub", &format!("stereo/{port}"), &value.to_string()]).expect_code(0);
    }
    daemon.ctl(&["start", "--wait", "stereo", "correlate", "images=1"])
}

#[test]
fn images_of_a_wrong_size_or_encoding_end_the_activity_with_its_exception() {
    for backend in ["local", "shm"] {
        let stereo = component("stereo");
        let daemon = Daemon::start(&["--backend", backend, path(&stereo.library)]);
        let right = frame((8, 4), "mono8", 32);
        for (left, told) in [
            (
                frame((4, 4), "mono8", 16),
                "::stereo::BAD_SIZE {\"port\":\"left\",\"width\":4,\"height\":4,\"bytes\":16,\
                 \"expected_width\":8,\"expected_height\":4}",
            ),
            (
                frame((8, 4), "mono8", 31),
                "::stereo::BAD_SIZE {\"port\":\"left\",\"width\":8,\"height\":4,\"bytes\":31,\
                 \"expected_width\":8,\"expected_height\":4}",
            ),
            (
                frame((8, 4), "rgb8", 32),
                "::stereo::BAD_ENCODING {\"port\":\"left\",\"encoding\":\"rgb8\"}",
            ),
        ] {
            compared(&daemon, &left, &right).expect_code(1).expect_err(told);
        }
        let wrong = frame((8, 3), "mono8", 24);
        let told = "::stereo::BAD_SIZE {\"port\":\"right\",\"width\":8,\"height\":3,";
        compared(&daemon, &right, &wrong).expect_code(1).expect_err(told);
        // The component goes on, and takes images that fit.
        compared(&daemon, &right, &right).expect_code(0);
        let seen = daemon.port("stereo", "disparity");
        assert_eq!(seen["value"]["data"], json!(vec![0; 32]), "{seen}");
    }
}

#[test]
fn requests_out_of_range_name_the_quantity() {
    let [camera, stereo] = ["camera", "stereo"].map(component);
    let daemon = Daemon::start(&[path(&camera.library), path(&stereo.library)]);
    for (request, told) in [
        (["camera", "set_rate", "rate=0"], "\"what\":\"rate, images per second\""),
        (["camera", "set_rate", "rate=51"], "\"lower\":0.1,\"upper\":50.0"),
        (["camera", "set_distortion", "right_lens.k1=-0.3"], "\"what\":\"k1\""),
        (["stereo", "set_block", "block=4"], "::stereo::BAD_BLOCK {\"side\":4}"),
    ] {
        daemon.ctl(&[&["call"], &request[..]].concat()).expect_code(1).expect_err(told);
    }
}

#[test]
fn a_directory_that_cannot_be_made_ends_the_viewer_with_its_exception() {
    let viewer = component("viewer");
    let daemon = Daemon::start(&[path(&viewer.library)]);
    let file = daemon.home().path().join("file");
    std::fs::write(&file, "").unwrap();
    let directory = format!("directory={}/pictures", path(&file));
    let refused = daemon.ctl(&["start", "--wait", "viewer", "watch", &directory]);
    refused
        .expect_code(1)
        .expect_err("::viewer::CANNOT_WRITE {\"path\":\"")
        .expect_err("/pictures\"");
}
