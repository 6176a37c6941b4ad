//! Requests from within the process.

use axum::Router;
use axum::body::Body;
use axum::http::{Request, header};
use axum::response::Response;
use genom_protocol::routes::Route;
use genom_protocol::{Code, Reason, Refusal};
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use serde::Serialize;
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

/// What a daemon itself may ask, also of its cells. Nobody's rights are checked here, and none of the
/// connections is taken that clients may use.
#[derive(Clone, Debug)]
pub struct Own(Router);

impl Own {
    /// Asks this router.
    #[must_use]
    pub const fn new(router: Router) -> Self {
        Self(router)
    }

    /// What a route answers if it succeeds.
    pub async fn read<R: DeserializeOwned, Q>(&self, route: &Route<R, Q>) -> Option<R> {
        self.ask(route, None).await.ok()
    }

    /// Makes a request, with the body that the route takes.
    ///
    /// # Errors
    /// It was refused.
    pub async fn ask<R, Q, B>(&self, route: &Route<R, Q, B>, body: Option<&B>) -> Result<R, Reason>
    where
        R: DeserializeOwned,
        B: Serialize,
    {
        let broken = |error: &dyn std::fmt::Display| Reason::new(Code::Internal, error.to_string());
        let request = Request::builder().method(route.method.as_str()).uri(&route.path);
        let request = match body {
            Some(body) => {
                let body = serde_json::to_vec(body).map_err(|error| broken(&error))?;
                request.header(header::CONTENT_TYPE, "application/json").body(Body::from(body))
            }
            None => request.body(Body::empty()),
        };
        let request = request.map_err(|error| broken(&error))?;
        let response = ask_within(self.0.clone(), request).await;
        let status = response.status();
        let bytes = axum::body::to_bytes(response.into_body(), LARGEST).await;
        let bytes = bytes.map_err(|error| broken(&error))?;
        if status.is_success() {
            return serde_json::from_slice(&bytes).map_err(|error| broken(&error));
        }
        let refusal = serde_json::from_slice::<Refusal>(&bytes);
        Err(refusal.map_or_else(|_| broken(&status), |refusal| refusal.error))
    }
}
