//! Frames for tf2: ports of the type `frames` of `docs/ros2.md`, on `/tf` and `/tf_static`.

mod samples;

use std::path::Path;

use samples::{Arm, TF, told, write};

use super::*;

#[test]
fn tf2_gets_the_frames_of_a_component_and_the_static_ones_though_it_comes_late() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let Arm { mut moving, mut fixed } = Arm::open(domain.options());
    write(&mut *fixed, "base", "camera", 0.25);

    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let package = package.join("../../components/build/ros2/tf2_msgs").canonicalize().unwrap();
    let types = genom_components::ros2::types(&package).unwrap();
    let mut node = genom_components::ros2::node(domain.number().into(), Some(&types)).unwrap();
    let mut peer = Peer::start(&mut node);
    // With the quality of service of tf2's own listener.
    peer.ask(&json!(["read", "/tf_static", TF, 1, true]));
    assert_eq!(peer.ask(&json!(["sample", "/tf_static"])), told("base", "camera", 0.25));
    write(&mut *moving, "base", "hand", 1.0);
    peer.ask(&json!(["read", "/tf", TF]));
    assert_eq!(peer.ask(&json!(["sample", "/tf"])), told("base", "hand", 1.0));
    for n in 2..5 {
        write(&mut *moving, "base", "hand", f64::from(n));
        assert_eq!(peer.ask(&json!(["sample", "/tf"])), told("base", "hand", f64::from(n)));
    }
}
