//! Requests to the control plane from within the process, in the name of a client.

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{Request, header};
use axum::response::Response;
use genom_doors::{Holder, Peer, ask_within};
use genom_protocol::routes::{Method, Route};
use genom_protocol::{Reason, Refusal};
use http_body_util::{BodyExt as _, Limited};
use serde::de::DeserializeOwned;

/// Longest reply that is read, in bytes.
const LONGEST: usize = 64 << 20;

/// The control plane, behind [`Door::proved`](genom_doors::Door::proved).
#[derive(Clone, Debug)]
pub(crate) struct Inside(Router);

/// Who asks.
#[derive(Clone, Debug)]
pub(crate) struct Asker {
    pub(crate) holder: Holder,
    pub(crate) peer: Option<Peer>,
}

/// Why nothing was done, as one sentence for people.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Refused(pub(crate) String);

impl Inside {
    pub(crate) fn new(api: Router) -> Self {
        Self(api)
    }

    /// Makes a request; `body` is what the route takes, or empty.
    pub(crate) async fn ask<R: DeserializeOwned, Q, B>(
        &self,
        by: &Asker,
        route: &Route<R, Q, B>,
        body: impl Into<Bytes>,
    ) -> Result<R, Refused> {
        let response = self.open(by, route, body).await?;
        let read = whole(response).await?;
        serde_json::from_slice(&read).map_err(|error| Refused(format!("the reply: {error}")))
    }

    /// Makes a request, and returns the reply once it is known to be none that refuses.
    pub(crate) async fn open<R, Q, B>(
        &self,
        by: &Asker,
        route: &Route<R, Q, B>,
        body: impl Into<Bytes>,
    ) -> Result<Response, Refused> {
        let body = body.into();
        let mut request = Request::builder().method(route.method.as_str()).uri(&route.path);
        if route.method != Method::Get {
            request = request.header(header::CONTENT_TYPE, "application/json");
        }
        let request = request.body(Body::from(body));
        let mut request = request.map_err(|error| Refused(error.to_string()))?;
        request.extensions_mut().insert(by.holder.clone());
        if let Some(peer) = by.peer {
            request.extensions_mut().insert(peer);
        }
        let response = ask_within(self.0.clone(), request).await;
        if response.status().is_success() {
            return Ok(response);
        }
        let status = response.status();
        let said = serde_json::from_slice::<Refusal>(&whole(response).await?);
        Err(said.map_or_else(|_| Refused(status.to_string()), |Refusal { error }| told(error)))
    }
}

fn told(Reason { message, help, .. }: Reason) -> Refused {
    Refused(help.map_or_else(|| message.clone(), |help| format!("{message}; {help}")))
}

async fn whole(response: Response) -> Result<Bytes, Refused> {
    let body = Limited::new(response.into_body(), LONGEST).collect().await;
    body.map(|body| body.to_bytes()).map_err(|error| Refused(error.to_string()))
}
