//! Shared memory holds what every middleware must hold.

mod world;

use world::ShmWorld;

genom_conformance::conformance! { shm: ShmWorld::new() }
