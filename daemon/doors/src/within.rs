//! Requests from within the process.

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use axum::response::Response;
use genom_protocol::routes::Route;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use serde::de::DeserializeOwned;

/// Bytes of a reply that is read.
const LARGEST: usize = 256 << 20;

/// Whether `GET path` succeeds, whatever clients do at the sockets. It takes none of the connections
/// that clients may use.
pub async fn answers(router: Router, path: &str) -> bool {
    let Ok(request) = Request::get(path).body(Body::empty()) else { return false };
    ask_within(router, request).await.status().is_success()
}

/// Makes a request. Behind `Door::proved`, a `Holder` among its extensions says who makes it.
pub async fn ask_within(router: Router, request: Request<Body>) -> Response {
    match TowerToHyperService::new(router).call(request).await {
        Ok(response) => response,
        Err(never) => match never {},
    }
}

/// What a daemon itself may ask: all that answers `GET`, with what its cells answer. Nobody's rights
/// are checked here.
#[derive(Clone, Debug)]
pub struct Own(Router);

impl Own {
    /// Asks this router.
    #[must_use]
    pub const fn new(router: Router) -> Self {
        Self(router)
    }

    /// What a route answers if it succeeds. It takes none of the connections that clients may use.
    pub async fn read<R: DeserializeOwned, Q>(&self, route: &Route<R, Q>) -> Option<R> {
        let request = Request::get(&route.path).body(Body::empty()).ok()?;
        let response = ask_within(self.0.clone(), request).await;
        if !response.status().is_success() {
            return None;
        }
        let bytes = axum::body::to_bytes(response.into_body(), LARGEST).await.ok()?;
        serde_json::from_slice(&bytes).ok()
    }
}
