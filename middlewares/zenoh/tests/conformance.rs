//! The zenoh middleware holds what every middleware must hold.

mod world;

use world::Meeting;

genom_conformance::conformance! { zenoh: Meeting::new() }
