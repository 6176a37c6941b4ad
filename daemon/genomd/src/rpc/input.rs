//! What comes with a request: a JSON body, query parameters.

use axum::body::Bytes;
use axum::extract::rejection::{BytesRejection, QueryRejection};
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::StatusCode;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use crate::nearest::nearest;
use crate::rpc::error::RpcError;

/// A JSON body; an empty one is `{}`.
#[derive(Debug)]
pub(crate) struct Body<T>(pub(crate) T);

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
pub(crate) struct Parameters<T>(pub(crate) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for Parameters<T> {
    type Rejection = RpcError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, RpcError> {
        Query::from_request_parts(parts, state).await.map(|Query(found)| Self(found)).map_err(
            |rejection: QueryRejection| {
                RpcError::new(StatusCode::BAD_REQUEST, "bad_query", rejection.body_text())
            },
        )
    }
}

fn unreadable(rejection: BytesRejection) -> RpcError {
    match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => RpcError::too_large(),
        _ => RpcError::new(StatusCode::BAD_REQUEST, "unreadable", rejection.body_text()),
    }
}

/// 400 for text that is no JSON, 422 for JSON of another shape.
fn misshapen(error: &serde_json::Error) -> RpcError {
    if !error.is_data() {
        return RpcError::new(StatusCode::BAD_REQUEST, "malformed", error.to_string());
    }
    let message = error.to_string();
    // Serde says: unknown field `x`, expected one of `a`, `b` at line 1 column 2.
    let mut quoted = message.split('`').skip(1).step_by(2);
    let near = message
        .starts_with("unknown field")
        .then(|| quoted.next().and_then(|unknown| nearest(unknown, quoted)))
        .flatten()
        .map(|near| format!("did you mean `{near}`?"));
    let refused = RpcError::bad_input(message.clone());
    match near {
        Some(help) => refused.help(help),
        None => refused,
    }
}
