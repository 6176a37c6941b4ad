//! Requests to the control plane from within the console, with the rights of a session.

use axum::Router;
use axum::body::Body;
use axum::extract::{MatchedPath, Request};
use axum::http::{Extensions, StatusCode, Uri, header};
use axum::response::Response;
use genom_doors::RpcError;
use genom_protocol::Code;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;

/// Headers between the browser and the console, which are none of the control plane's business. It
/// refuses all requests of web pages; those of the console were checked.
const OURS: [header::HeaderName; 4] =
    [header::COOKIE, header::ORIGIN, header::AUTHORIZATION, header::REFERER];

/// The control plane, behind [`Door::proved`](genom_doors::Door::proved).
#[derive(Clone, Debug)]
pub(crate) struct Inside(pub(crate) Router);

impl Inside {
    /// Passes a request on to this path. Its extensions say who made it.
    pub(crate) async fn pass(&self, mut request: Request, path: &str) -> Response {
        let Ok(uri) = path.parse::<Uri>() else {
            return axum::response::IntoResponse::into_response(RpcError::new(
                StatusCode::BAD_REQUEST,
                Code::BadQuery,
                "the path is none",
            ));
        };
        *request.uri_mut() = uri;
        // The right that is asked for is that of the route of the control plane.
        request.extensions_mut().remove::<MatchedPath>();
        for name in OURS {
            request.headers_mut().remove(name);
        }
        match TowerToHyperService::new(self.0.clone()).call(request).await {
            Ok(response) => response,
            Err(never) => match never {},
        }
    }

    /// Reads a path, for whoever the extensions say.
    pub(crate) async fn read(&self, path: &str, extensions: Extensions) -> Response {
        let mut request = Request::new(Body::empty());
        *request.extensions_mut() = extensions;
        self.pass(request, path).await
    }
}
