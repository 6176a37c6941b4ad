//! Extractors of JSON bodies and query parameters.

use std::time::Duration;

use axum::body::{self, Bytes};
use axum::extract::rejection::{BytesRejection, QueryRejection};
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_nearest::nearest_key;
use genom_protocol::Code;
use serde::de::DeserializeOwned;
use tokio::time::timeout;

use crate::error::RpcError;

/// A peer must have sent its body within this time.
const SLOWEST_WRITER: Duration = Duration::from_secs(10);

/// Maximum of `wait`, in seconds.
const LONGEST_WAIT: f64 = 3600.0;

/// The time that a request with `?wait=SECONDS` is held, at most an hour.
///
/// # Errors
/// The value is not a number of seconds.
pub fn wait(seconds: f64) -> Result<Duration, RpcError> {
    Duration::try_from_secs_f64(seconds.min(LONGEST_WAIT)).map_err(|_| {
        RpcError::bad_input(format!("wait: {seconds} is no number of seconds")).place("wait")
    })
}

/// A JSON body; an empty body means `{}`.
#[derive(Debug)]
pub struct Body<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Body<T> {
    type Rejection = RpcError;

    async fn from_request(request: Request, state: &S) -> Result<Self, RpcError> {
        let bytes = Bytes::from_request(request, state).await.map_err(unreadable)?;
        let bytes: &[u8] = if bytes.is_empty() { b"{}" } else { &bytes };
        serde_json::from_slice(bytes).map(Body).map_err(|error| misshapen(&error))
    }
}

/// Query parameters.
#[derive(Debug)]
pub struct Parameters<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for Parameters<T> {
    type Rejection = RpcError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, RpcError> {
        Query::from_request_parts(parts, state).await.map(|Query(found)| Self(found)).map_err(
            |rejection: QueryRejection| {
                RpcError::new(StatusCode::BAD_REQUEST, Code::BadQuery, rejection.body_text())
            },
        )
    }
}

/// Reads the whole body before anything else, even if it is not needed: closing a connection with
/// unread bytes resets it, and the peer may then lose the reply.
pub(crate) async fn read_whole(request: Request, next: Next) -> Response {
    let (parts, content) = request.into_parts();
    let reading = Bytes::from_request(Request::from_parts(parts.clone(), content), &());
    let bytes = match timeout(SLOWEST_WRITER, reading).await {
        Err(_) => return too_slow().into_response(),
        Ok(Err(rejection)) => return unreadable(rejection).into_response(),
        Ok(Ok(bytes)) => bytes,
    };
    next.run(Request::from_parts(parts, body::Body::from(bytes))).await
}

fn too_slow() -> RpcError {
    let message = format!("the request's body did not come within {SLOWEST_WRITER:?}");
    RpcError::new(StatusCode::REQUEST_TIMEOUT, Code::TooSlow, message)
}

fn unreadable(rejection: BytesRejection) -> RpcError {
    match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => RpcError::too_large(),
        _ => RpcError::new(StatusCode::BAD_REQUEST, Code::Unreadable, rejection.body_text()),
    }
}

/// 400 for text that is not JSON, 422 for JSON of another form.
fn misshapen(error: &serde_json::Error) -> RpcError {
    if !error.is_data() {
        return RpcError::new(StatusCode::BAD_REQUEST, Code::Malformed, error.to_string());
    }
    let message = error.to_string();
    let near = nearest_key(&message);
    let refused = RpcError::bad_input(message);
    match near {
        Some(near) => refused.help(format!("did you mean `{near}`?")),
        None => refused,
    }
}
