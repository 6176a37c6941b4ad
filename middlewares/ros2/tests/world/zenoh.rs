//! A router's address per test, so that nodes of other tests and processes are not met.

use std::sync::Arc;

use genom_conformance::World;
use genom_middleware::Middleware;
use genom_ros2::{Options, Rmw, Ros2, ZenohOptions};

/// A place where one test's nodes find each other.
pub(crate) struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    /// The endpoint of the router.
    pub(crate) fn router(&self) -> String {
        format!("unixsock-stream/{}", self.folder.path().join("router").display())
    }

    pub(crate) fn options(&self) -> Options {
        options(&self.router())
    }

    pub(crate) fn open(&self) -> Arc<Ros2> {
        Ros2::open(&self.options()).expect("a session")
    }
}

/// With the router at this endpoint.
pub(crate) fn options(router: &str) -> Options {
    let zenoh = ZenohOptions {
        connect: Some(vec![router.to_owned()]),
        listen: Some(vec!["tcp/127.0.0.1:0".to_owned()]),
        ..ZenohOptions::default()
    };
    Options { rmw: Some(Rmw::Zenoh), domain: Some(0), zenoh, ..Options::default() }
}

impl World for Place {
    fn join(&self) -> Arc<dyn Middleware> {
        self.open()
    }
}
