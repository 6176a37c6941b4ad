//! Frames for tf2, which hiroz has no types for: it takes them apart by the description that our node
//! gives, and reads them under the hash that it computes of that.

#[path = "../frames/samples.rs"]
mod samples;

use samples::{Arm, TF, told, write};

use super::*;

/// As ROS 2 Jazzy publishes it.
const TF_HASH: &str = "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087";

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_gets_frames_of_a_component_and_the_static_ones_though_it_comes_late() {
    let place = Place::new();
    let Arm { mut moving, mut fixed } = Arm::open(place.options());
    write(&mut *fixed, "base", "camera", 0.25);

    let mut node = node(&place);
    let learned = json!({"type": TF, "told": TF_HASH, "hash": TF_HASH});
    assert_eq!(node.ask(&json!(["learn", "/tf_static", true])), learned);
    let sample = node.ask(&json!(["learned", "/tf_static"]));
    assert_eq!(sample, told("base", "camera", 0.25));
    assert_eq!(node.ask(&json!(["learn", "/tf"])), learned);
    eventually("it is connected", || {
        write(&mut *moving, "base", "hand", 1.0);
        node.ask(&json!(["any learned", "/tf"])) == told("base", "hand", 1.0)
    });
    for n in 2..5 {
        write(&mut *moving, "base", "hand", f64::from(n));
        let mut sample = node.ask(&json!(["learned", "/tf"]));
        while n == 2 && sample == told("base", "hand", 1.0) {
            sample = node.ask(&json!(["learned", "/tf"]));
        }
        assert_eq!(sample, told("base", "hand", f64::from(n)));
    }
}
