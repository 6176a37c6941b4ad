//! Frames for tf2: ports of the type `frames` of `docs/ros2.md`, on `/tf` and `/tf_static`.

mod samples;

use std::path::Path;

use genom_middleware::{Middleware, Quality};
use samples::{TF, frames, told, write};

use super::*;

#[test]
fn tf2_gets_the_frames_of_a_component_and_the_static_ones_though_it_comes_late() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let masquerade = [("::arm::frames".to_owned(), TF.to_owned())].into();
    let ros2 = Ros2::open(&Options { masquerade, ..domain.options() }).unwrap();
    ros2.masquerade("arm/moving", "/tf").unwrap();
    ros2.masquerade("arm/fixed", "/tf_static").unwrap();
    let (moving, fixed) = (Address::new("arm", "moving"), Address::new("arm", "fixed"));
    let ty = frames();
    let mut moving = ros2.publisher(&PortSpec::new(&moving, &ty)).unwrap();
    let latched = Quality { transient_local: Some(true), ..Quality::default() };
    let mut fixed = ros2.publisher(&PortSpec::new(&fixed, &ty).of(latched)).unwrap();
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
