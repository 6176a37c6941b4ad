//! Requests to a cell over its private socket, by HTTP/1.1.

use std::path::{Path, PathBuf};

use genom_protocol::routes::{self, Route};
use genom_protocol::sse::LAST_EVENT_ID;
use genom_protocol::{Reason, Refusal};
use http_body_util::{BodyExt as _, Full};
use hyper::body::{Body, Bytes, Incoming};
use hyper::client::conn::http1;
use hyper::{Request, Response, header};
use hyper_util::rt::TokioIo;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::net::UnixStream;

use crate::theirs;

/// Why a cell did not do what it was asked.
#[derive(Clone, Debug, thiserror::Error)]
pub enum AskError {
    /// Nobody is at the socket, or who was there went away.
    #[error("the cell's process does not answer: {0}")]
    Gone(String),
    /// It refuses.
    #[error("{}", .1.message)]
    Refused(u16, Box<Reason>),
    /// What it answered is of another shape: it is of another version.
    #[error("the cell's answer cannot be read: {0}")]
    Misread(String),
}

/// Talks to one cell. Each request is a connection of its own, so that none waits for another.
#[derive(Clone, Debug)]
pub(crate) struct Client {
    socket: PathBuf,
}

fn gone(error: impl std::fmt::Display) -> AskError {
    AskError::Gone(error.to_string())
}

impl Client {
    pub(crate) fn new(socket: &Path) -> Self {
        Self { socket: socket.to_owned() }
    }

    /// Passes a request on as it is.
    pub(crate) async fn send<B>(&self, request: Request<B>) -> Result<Response<Incoming>, AskError>
    where
        B: Body + Send + Unpin + 'static,
        B::Data: Send,
        B::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let (_held, path) = theirs::socket(&self.socket).map_err(gone)?;
        let stream = UnixStream::connect(&path).await.map_err(gone)?;
        let (mut sender, connection) =
            http1::handshake(TokioIo::new(stream)).await.map_err(gone)?;
        // It ends when the response's body was read or dropped.
        tokio::spawn(connection);
        sender.send_request(request).await.map_err(gone)
    }

    /// Asks a route without a body.
    pub(crate) async fn ask<R: DeserializeOwned, Q>(
        &self,
        route: &Route<R, Q>,
    ) -> Result<R, AskError> {
        self.read(route.method, &route.path, Bytes::new()).await
    }

    /// Asks a route with a body.
    pub(crate) async fn tell<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: &Route<R, Q, B>,
        body: &B,
    ) -> Result<R, AskError> {
        let body =
            serde_json::to_vec(body).map_err(|error| AskError::Misread(error.to_string()))?;
        self.read(route.method, &route.path, body.into()).await
    }

    /// Opens a stream of bytes.
    pub(crate) async fn open(
        &self,
        path: &str,
        after: Option<u64>,
    ) -> Result<Response<Incoming>, AskError> {
        let mut request = self.request(routes::Method::Get, path);
        if let Some(after) = after {
            request = request.header(LAST_EVENT_ID, after);
        }
        let request = request.body(Full::new(Bytes::new()));
        self.send(request.map_err(|error| AskError::Misread(error.to_string()))?).await
    }

    /// Asks a route with a body that is no JSON.
    pub(crate) async fn send_bytes<R: DeserializeOwned, Q>(
        &self,
        route: &Route<R, Q, routes::Bytes>,
        body: Bytes,
    ) -> Result<R, AskError> {
        self.read(route.method, &route.path, body).await
    }

    /// Asks a route that answers with bytes. One that takes no body ignores what it gets.
    pub(crate) async fn stream<Q, B: Serialize>(
        &self,
        route: &Route<routes::Bytes, Q, B>,
        body: &B,
    ) -> Result<Response<Incoming>, AskError> {
        let body =
            serde_json::to_vec(body).map_err(|error| AskError::Misread(error.to_string()))?;
        let request = self.request(route.method, &route.path).body(Full::new(body.into()));
        let request = request.map_err(|error| AskError::Misread(error.to_string()))?;
        let response = self.send::<Full<Bytes>>(request).await?;
        match response.status().is_success() {
            true => Ok(response),
            false => Err(refusal(response).await),
        }
    }

    fn request(&self, method: routes::Method, path: &str) -> hyper::http::request::Builder {
        Request::builder()
            .method(method.as_str())
            .uri(path)
            .header(header::HOST, "cell")
            .header(header::CONTENT_TYPE, "application/json")
    }

    async fn read<R: DeserializeOwned>(
        &self,
        method: routes::Method,
        path: &str,
        body: Bytes,
    ) -> Result<R, AskError> {
        let misread = |error: &dyn std::fmt::Display| AskError::Misread(error.to_string());
        let request = self.request(method, path).body(Full::new(body));
        let response = self.send(request.map_err(|error| misread(&error))?).await?;
        let status = response.status();
        if !status.is_success() {
            return Err(refusal(response).await);
        }
        let bytes = response.into_body().collect().await.map_err(gone)?.to_bytes();
        serde_json::from_slice(&bytes).map_err(|error| misread(&error))
    }
}

/// Why a request was refused.
async fn refusal(response: Response<Incoming>) -> AskError {
    let status = response.status().as_u16();
    let bytes = match response.into_body().collect().await {
        Ok(body) => body.to_bytes(),
        Err(error) => return gone(error),
    };
    match serde_json::from_slice::<Refusal>(&bytes) {
        Ok(refusal) => AskError::Refused(status, Box::new(refusal.error)),
        Err(error) => AskError::Misread(format!("status {status}: {error}")),
    }
}
