//! A DDS domain per test, so that participants of other tests and processes are not seen.

#![allow(clippy::expect_used, clippy::panic, reason = "test code")]

use std::fs::{File, TryLockError};
use std::process::Command;
use std::sync::Arc;

use genom_components::peer::Lines;
use genom_conformance::World;
use genom_middleware::Middleware;
use genom_ros2::{Options, Rmw, Ros2, ServiceMapping};

/// UDP ports of domains above this one are in the range of ephemeral ports.
const LAST: u16 = 101;

/// A domain that nobody else on this machine uses while this exists.
pub(crate) struct Domain {
    number: u16,
    services: ServiceMapping,
    /// Locked; the system releases the lock when the process ends.
    _lock: File,
}

impl Domain {
    pub(crate) fn new(services: ServiceMapping) -> Self {
        let free = (1..=LAST).find_map(|number| {
            let path = std::env::temp_dir().join(format!("genom-ros2-domain-{number}.lock"));
            let lock = File::options().create(true).append(true).open(path).expect("a lock");
            match lock.try_lock() {
                Ok(()) => Some(Self { number, services, _lock: lock }),
                Err(TryLockError::WouldBlock) => None,
                Err(TryLockError::Error(error)) => panic!("{error}"),
            }
        });
        free.expect("a domain that no other test uses")
    }

    #[allow(dead_code, reason = "not all tests look")]
    pub(crate) fn number(&self) -> u16 {
        self.number
    }

    pub(crate) fn options(&self) -> Options {
        Options {
            rmw: Some(Rmw::Dds),
            domain: Some(self.number),
            services: self.services,
            ..Options::default()
        }
    }

    /// Starts a foreign DDS peer: `peer.py` with these arguments.
    #[allow(dead_code, reason = "not all tests have one")]
    pub(crate) fn peer(&self, arguments: &[&str]) -> Lines {
        let python = genom_components::python::environment(&["cyclonedds==11.0.1"])
            .unwrap_or_else(|error| panic!("the peer in Python cannot be had: {error}"));
        let mut command = Command::new(python);
        command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"));
        command.arg(self.number.to_string()).args(arguments);
        Lines::start(&mut command)
    }

    pub(crate) fn open(&self) -> Arc<Ros2> {
        Ros2::open(&self.options()).expect("a participant")
    }
}

impl World for Domain {
    fn join(&self) -> Arc<dyn Middleware> {
        self.open()
    }
}
