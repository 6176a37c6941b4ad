//! zenoh in a library of its own passes the conformance suite: opened as a file, through the table.

#![allow(clippy::expect_used, reason = "test code")]

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use genom_conformance::World;
use genom_middleware::Middleware;
use genom_plugin_host::Library;
use serde_json::json;
use tempfile::TempDir;

/// Beside this program: cargo builds it for this test.
fn library() -> &'static Library {
    let program = std::env::current_exe().expect("this program");
    let path: PathBuf = program.with_file_name("libgenomd_zenoh_plugin.so");
    Library::open(&path).expect("a middleware")
}

/// A folder in which sessions find each other.
struct Meeting(TempDir);

impl World for Meeting {
    fn join(&self) -> Arc<dyn Middleware> {
        let options = json!({ "rendezvous": self.0.path() }).to_string();
        library().middleware(&options).expect("a session")
    }

    fn leftovers(&self) -> Vec<String> {
        let files = fs::read_dir(self.0.path()).expect("a directory");
        files.map(|file| file.expect("a file").path().display().to_string()).collect()
    }
}

genom_conformance::conformance! {
    zenoh_plugin: Meeting(tempfile::tempdir().expect("a directory"))
}

#[test]
fn options_that_zenoh_does_not_know_are_refused_by_the_plugin() {
    let told = library().middleware("{\"lisen\": []}").map(|_| ()).expect_err("a wrong key");
    assert!(told.to_string().contains("unknown field `lisen`"), "{told}");
}

#[test]
fn the_plugin_says_that_it_gains_from_a_gateway() {
    assert!(library().wants_gateway());
    assert_eq!(library().name(), "zenoh_plugin");
}
