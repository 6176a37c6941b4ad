//! The shared-memory backend passes the conformance suite.

mod world;

use world::ShmWorld;

genom_conformance::conformance! { shm: ShmWorld::new() }
