//! Two examples pass the conformance suite through the table: one in Rust and one in C, which is
//! compiled and opened as a user does.

mod built;

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use genom_example::Example;
use genom_middleware::Middleware;
use genom_plugin::abi::Plugin;
use genom_plugin_host::Library;

static TABLE: Plugin = genom_plugin::table::<Example>("example");

/// Name of a board that no other test uses.
fn board() -> String {
    static BOARDS: AtomicU32 = AtomicU32::new(0);
    BOARDS.fetch_add(1, Ordering::Relaxed).to_string()
}

genom_conformance::conformance! {
    plugin: {
        let options = format!("{{\"board\": \"{}\"}}", board());
        move || -> Arc<dyn Middleware> {
            let library = Library::built_in(&TABLE).expect("a table");
            library.middleware(&options).expect("a thread")
        }
    },
    plugin_in_c: {
        let options = format!("{{\"board\": \"{}\"}}", board());
        move || -> Arc<dyn Middleware> {
            let library = Library::open(&built::BOARD.path).expect("a middleware");
            library.middleware(&options).expect("it opens")
        }
    },
}
