//! Gateways on threads of the test, each with a socket of its own.

#![allow(clippy::expect_used, clippy::panic, reason = "test code")]

use std::fs::{self, File, TryLockError};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use genom_conformance::World;
use genom_gateway::{Listening, Proxy, Reach, Server};
use genom_middleware::Middleware;
use genom_ros2::Ros2;
use genom_zenoh::Zenoh;
use tempfile::TempDir;

/// Which middleware is behind the gateways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Zenoh,
    Ros2,
}

/// Where a test's participants meet, and the sockets of their gateways.
pub(crate) struct House {
    kind: Kind,
    /// Whether all participants use one gateway, as the cells of one daemon do.
    shared: bool,
    /// With their numbers. Dropped before their files.
    gateways: Mutex<Vec<(usize, Listening)>>,
    next: AtomicUsize,
    place: TempDir,
    /// The DDS domain, and the lock that says so.
    domain: Option<(u16, File)>,
}

/// UDP ports of domains above this one are in the range of ephemeral ports.
const LAST: u16 = 101;

/// A domain that no other test of this machine uses.
fn domain() -> (u16, File) {
    let free = (1..=LAST).find_map(|number| {
        let path = std::env::temp_dir().join(format!("genom-ros2-domain-{number}.lock"));
        let lock = File::options().create(true).append(true).open(path).expect("a lock");
        match lock.try_lock() {
            Ok(()) => Some((number, lock)),
            Err(TryLockError::WouldBlock) => None,
            Err(TryLockError::Error(error)) => panic!("{error}"),
        }
    });
    free.expect("a domain that no other test uses")
}

impl House {
    pub(crate) fn new(kind: Kind, shared: bool) -> Self {
        let domain = (kind == Kind::Ros2).then(domain);
        let place = tempfile::tempdir().expect("a directory");
        fs::create_dir(place.path().join("meeting")).expect("a directory");
        Self { kind, shared, gateways: Mutex::default(), next: AtomicUsize::new(0), place, domain }
    }

    fn meeting(&self) -> PathBuf {
        self.place.path().join("meeting")
    }

    /// The middleware without a gateway.
    pub(crate) fn direct(&self) -> Arc<dyn Middleware> {
        match &self.domain {
            Some((number, _)) => {
                let options = genom_ros2::Options { domain: Some(*number), ..Default::default() };
                Ros2::open(&options).expect("a participant")
            }
            None => {
                let rendezvous = Some(self.meeting());
                let options = genom_zenoh::Options { rendezvous, ..Default::default() };
                Zenoh::open(&options).expect("a session")
            }
        }
    }

    pub(crate) fn name(&self) -> &'static str {
        match self.kind {
            Kind::Zenoh => "zenoh",
            Kind::Ros2 => "ros2",
        }
    }

    /// Where the gateway of this number is.
    pub(crate) fn reach(&self, number: usize) -> Reach {
        Reach::new(&self.place.path().join(number.to_string()))
    }

    /// Starts the gateway of this number.
    pub(crate) fn gateway(&self, number: usize) -> Listening {
        let door = self.reach(number).door(self.name());
        fs::create_dir_all(door.parent().expect("a directory")).expect("a directory");
        Server::listen(&door, self.direct()).expect("a gateway")
    }

    /// Opens the middleware of the gateway of this number.
    pub(crate) fn proxy(&self, number: usize) -> Arc<dyn Middleware> {
        Arc::new(Proxy::open(self.name(), self.reach(number)).expect("a gateway"))
    }
}

impl World for House {
    fn join(&self) -> Arc<dyn Middleware> {
        let mut gateways = self.gateways.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.shared {
            // They end when nobody uses them any more, as their processes do.
            gateways.retain(|(_, gateway)| gateway.is_used());
        }
        let number = if self.shared { 0 } else { self.next.fetch_add(1, Ordering::Relaxed) };
        if !gateways.iter().any(|(one, _)| *one == number) {
            let gateway = self.gateway(number);
            gateways.push((number, gateway));
        }
        drop(gateways);
        self.proxy(number)
    }

    fn leftovers(&self) -> Vec<String> {
        self.gateways.lock().unwrap_or_else(PoisonError::into_inner).clear();
        let files = fs::read_dir(self.meeting()).expect("a directory");
        files.map(|file| file.expect("a file").path().display().to_string()).collect()
    }
}
