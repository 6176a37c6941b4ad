//! The zenoh backend passes the conformance suite.

mod world;

use world::Meeting;

genom_conformance::conformance! { zenoh: Meeting::new() }
