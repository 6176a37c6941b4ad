//! The example passes the conformance suite.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use genom_example::{Example, Options};
use genom_middleware::{Backend as _, Middleware};

/// Name of a board that no other test uses.
fn board() -> String {
    static BOARDS: AtomicU32 = AtomicU32::new(0);
    BOARDS.fetch_add(1, Ordering::Relaxed).to_string()
}

genom_conformance::conformance! {
    example: {
        let options = Options { board: board() };
        move || -> Arc<dyn Middleware> { Example::open(options.clone()).expect("a thread") }
    }
}
