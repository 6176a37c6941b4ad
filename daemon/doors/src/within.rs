//! Requests from within the process.

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use axum::response::Response;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;

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
