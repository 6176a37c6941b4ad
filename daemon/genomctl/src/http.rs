//! Makes one HTTP/1.1 request to the daemon.

use std::sync::Arc;

use genom_protocol::Refusal;
use genom_protocol::sse::LAST_EVENT_ID;
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper::{Method, Request, header};
use hyper_util::rt::TokioIo;
use serde_json::Value;

use crate::body::Body;
use crate::escape;
use crate::failure::Failure;
use crate::patience::Watch;
use crate::target::Target;

/// A response.
pub(crate) struct Response {
    /// HTTP status.
    pub(crate) status: u16,
    pub(crate) body: Body,
}

impl Response {
    pub(crate) fn is_success(&self) -> bool {
        (200..300).contains(&self.status)
    }

    /// The whole body as JSON; a refusal becomes an error.
    pub(crate) async fn json(self, target: &Target) -> Result<Value, Failure> {
        if !self.is_success() {
            return Err(self.refusal(target).await);
        }
        let bytes = self.body.whole().await?.ok_or_else(|| target.lost())?;
        if bytes.is_empty() {
            return Ok(Value::Null);
        }
        serde_json::from_slice(&bytes).map_err(|error| target.misread(error.to_string()))
    }

    /// The reason of a refusal.
    pub(crate) async fn refusal(self, target: &Target) -> Failure {
        let status = self.status;
        let bytes = match self.body.whole().await {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return target.lost(),
            Err(failure) => return failure,
        };
        let mut reply: Value = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
        // The text may be printed on a terminal.
        escape::all(&mut reply);
        match serde_json::from_value::<Refusal>(reply) {
            Ok(refusal) => Failure::Refused(refusal.error),
            Err(_) => target.misread(format!("status {status} without an error")),
        }
    }
}

/// Makes a request. `after` is the number of the last event received, to resume a stream.
pub(crate) async fn ask(
    target: &Arc<Target>,
    method: Method,
    path: &str,
    bytes: Bytes,
    after: Option<u64>,
) -> Result<Response, Failure> {
    let mut request = Request::builder()
        .method(method)
        .uri(path)
        .header(header::HOST, "genomd")
        .header(header::CONTENT_TYPE, "application/json");
    if let Some(authorization) = target.authorization() {
        request = request.header(header::AUTHORIZATION, authorization);
    }
    if let Some(after) = after {
        request = request.header(LAST_EVENT_ID, after);
    }
    let request =
        request.body(Full::new(bytes)).map_err(|error| target.misread(error.to_string()))?;
    let (stream, process) = target.open().await?;
    let watch = Watch::new(target, process);
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream))
        .await
        .map_err(|error| target.misread(error.to_string()))?;
    // This task ends when the reply's body was read or dropped.
    tokio::spawn(connection);
    let response = watch.over(sender.send_request(request)).await?.map_err(|error| {
        if error.is_parse() { target.misread(error.to_string()) } else { target.lost() }
    })?;
    let status = response.status().as_u16();
    Ok(Response { status, body: Body::Near(response.into_body(), watch) })
}
