//! A rendezvous folder per test: tests do not see each other and use no network.

#![allow(clippy::unwrap_used, reason = "test code that stands outside of test functions")]

use std::sync::Arc;

use genom_conformance::World;
use genom_middleware::Middleware;
use genom_zenoh::{Options, Zenoh};
use tempfile::TempDir;

pub(crate) struct Meeting(TempDir);

impl Meeting {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn options(&self) -> Options {
        Options { rendezvous: Some(self.0.path().to_owned()), ..Options::default() }
    }

    pub(crate) fn open(&self) -> Arc<Zenoh> {
        Zenoh::open(&self.options()).unwrap()
    }
}

impl World for Meeting {
    fn join(&self) -> Arc<dyn Middleware> {
        self.open()
    }

    fn leftovers(&self) -> Vec<String> {
        let files = std::fs::read_dir(self.0.path()).unwrap();
        files.map(|file| file.unwrap().path().display().to_string()).collect()
    }
}
