//! The local backend passes the conformance suite.

use std::sync::Arc;

use genom_local::Local;
use genom_middleware::Middleware;

genom_conformance::conformance! {
    local: {
        let shared = Local::new();
        move || -> Arc<dyn Middleware> { Arc::new(shared.clone()) }
    }
}
