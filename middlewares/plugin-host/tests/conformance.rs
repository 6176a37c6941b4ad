//! Two examples pass the conformance suite through the table: one in Rust and one in C, which is
//! compiled and opened as a user does; that in C also with samples in their C layout, and called by
//! the tasks themselves.

#![allow(clippy::expect_used, reason = "test code")]

mod built;

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, LazyLock};

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

static LAYOUT: LazyLock<built::Built> = LazyLock::new(|| built::board_that("GENOM_MW_LAYOUT"));

static DIRECT: LazyLock<built::Built> = LazyLock::new(|| built::board_that("GENOM_MW_RT_PUBLISH"));

fn open(library: &Path, options: &str) -> Arc<dyn Middleware> {
    let library = Library::open(library).expect("a middleware");
    library.middleware(options).expect("it opens")
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
        move || open(&built::BOARD.path, &options)
    },
    plugin_in_c_of_layouts: {
        let options = format!("{{\"board\": \"{}\"}}", board());
        move || open(&LAYOUT.path, &options)
    },
    plugin_in_c_called_by_tasks: {
        let options = format!("{{\"board\": \"{}\"}}", board());
        move || open(&DIRECT.path, &options)
    },
}
