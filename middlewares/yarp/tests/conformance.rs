//! The YARP backend passes the conformance suite, with a genuine name server for each property.

mod world;

use world::Place;

genom_conformance::conformance! { yarp: Place::new() }
