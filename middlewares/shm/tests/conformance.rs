//! Shared memory holds what every middleware must hold.

mod world;

use world::ShmWorld;

genom_middleware::conformance! { shm: ShmWorld::new() }
