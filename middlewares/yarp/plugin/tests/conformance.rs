//! YARP passes the conformance suite through the table of a library of its own, too.

#![allow(clippy::expect_used, reason = "test code outside of test functions")]

#[path = "../../tests/world/mod.rs"]
mod world;

use std::sync::Arc;

use genom_conformance::World;
use genom_middleware::Middleware;
use genom_plugin_host::Library;
use world::Place;

/// A name server, and participants that are opened as genomd opens a library.
struct Through(Place);

impl World for Through {
    fn join(&self) -> Arc<dyn Middleware> {
        // Beside this program: cargo builds it for this test.
        let program = std::env::current_exe().expect("this program");
        let library = program.with_file_name("libgenomd_yarp.so");
        let library = Library::open(&library).expect("a middleware");
        let options = serde_json::json!({"server": self.0.options().server}).to_string();
        library.middleware(&options).expect("it opens")
    }

    fn leftovers(&self) -> Vec<String> {
        self.0.leftovers()
    }
}

genom_conformance::conformance! { yarp: Through(Place::new()) }
