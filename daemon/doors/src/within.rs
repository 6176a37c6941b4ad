//! A request from within the process: whether handlers answer, whatever clients do at the sockets.

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;

/// Whether `GET path` succeeds. It takes none of the connections that clients may use.
pub async fn answers(router: Router, path: &str) -> bool {
    let Ok(request) = Request::get(path).body(Body::empty()) else { return false };
    match TowerToHyperService::new(router).call(request).await {
        Ok(response) => response.status().is_success(),
        Err(never) => match never {},
    }
}
