//! The routes of the console.

use axum::middleware::from_fn_with_state;
use axum::routing::get;
use axum::{Extension, Router};
use genom_doors::{Entrance, Listener};

use crate::assets;
use crate::console::Console;
use crate::gate;
use crate::inside::Inside;
use crate::live;
use crate::sign_in;

impl Console {
    /// What is behind its address. `api` is the control plane, behind
    /// [`Door::proved`](genom_doors::Door::proved).
    pub fn entrance(&self, listener: Listener, api: Router) -> Entrance {
        let signed_in = Router::new()
            .route("/live", get(live::open))
            // No route of its own: parameters of its path would be added to those of the control
            // plane's.
            .fallback(gate::pass)
            .layer(from_fn_with_state(self.clone(), gate::enter))
            .layer(Extension(Inside(api)));
        let router = Router::new()
            .route("/session", get(sign_in::look).post(sign_in::open).delete(sign_in::close))
            .route("/assets/{file}", get(assets::file))
            .route("/", get(assets::page))
            .route("/sign-in", get(assets::page))
            .route("/graph", get(assets::page))
            .route("/logs", get(assets::page))
            .route("/timeline", get(assets::page))
            .route("/doctor", get(assets::page))
            .route("/deployment", get(assets::page))
            .route("/recordings", get(assets::page))
            .route("/component/{name}", get(assets::page))
            .merge(signed_in)
            .layer(from_fn_with_state(self.clone(), gate::check))
            .with_state(self.clone());
        Entrance { listener, router }
    }
}
