//! HTTP/1.1 with JSON bodies to the daemon, over its Unix socket or TCP.

use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1;
use hyper::{Method, Request, Response, header};
use hyper_util::rt::TokioIo;
use serde_json::Value;

use crate::connection::Connection;
use crate::contexts;
use crate::failure::{Failure, Refusal};
use crate::sse::EventStream;
use crate::target::Target;

/// A daemon to talk to. Each request is a connection of its own: queries are rare and short.
#[derive(Debug)]
pub(crate) struct Client {
    given: Connection,
}

impl Client {
    /// A client of the daemon that the command line names; nothing is read or opened yet, since
    /// verbs that talk to no daemon work whatever contexts and tokens there are.
    pub(crate) fn new(given: Connection) -> Self {
        Self { given }
    }

    fn way(&self) -> Result<Target, Failure> {
        let (connection, chosen) = contexts::complete(self.given.clone())?;
        Target::new(connection, chosen)
    }

    /// Who is talked to, for messages.
    pub(crate) fn target(&self) -> String {
        self.way().map_or_else(|_| "?".to_owned(), |target| target.to_string())
    }

    /// Asks, and waits for the whole reply.
    pub(crate) async fn request(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Value, Failure> {
        let response = self.send(method, path, body).await?;
        self.whole(response).await
    }

    async fn whole(&self, response: Response<Incoming>) -> Result<Value, Failure> {
        let status = response.status();
        let bytes = response.into_body().collect().await.map_err(|_| self.lost())?.to_bytes();
        let reply: Value = if bytes.is_empty() {
            Value::Null
        } else {
            serde_json::from_slice(&bytes).map_err(|error| self.misread(error.to_string()))?
        };
        if status.is_success() { Ok(reply) } else { Err(self.refused(reply, status.as_u16())) }
    }

    /// Opens a stream of server-sent events.
    pub(crate) async fn stream(&self, path: &str) -> Result<EventStream, Failure> {
        self.resume(path, None).await
    }

    /// Opens a stream where another one broke: after the event of that number.
    pub(crate) async fn resume(
        &self,
        path: &str,
        after: Option<u64>,
    ) -> Result<EventStream, Failure> {
        let response = self.send_bytes(Method::GET, path, Bytes::new(), after).await?;
        let status = response.status();
        if status.is_success() {
            return Ok(EventStream::new(response.into_body()));
        }
        let bytes = response.into_body().collect().await.map_err(|_| self.lost())?.to_bytes();
        let reply = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
        Err(self.refused(reply, status.as_u16()))
    }

    /// `POST` of bytes.
    pub(crate) async fn post_bytes(&self, path: &str, body: Vec<u8>) -> Result<Value, Failure> {
        let response = self.send_bytes(Method::POST, path, body.into(), None).await?;
        self.whole(response).await
    }

    /// Asks, and gives the reply's body as it comes.
    pub(crate) async fn open(
        &self,
        method: Method,
        path: &str,
        body: &Value,
    ) -> Result<Incoming, Failure> {
        let response = self.send(method, path, Some(body)).await?;
        let status = response.status();
        if status.is_success() {
            return Ok(response.into_body());
        }
        let bytes = response.into_body().collect().await.map_err(|_| self.lost())?.to_bytes();
        let reply = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
        Err(self.refused(reply, status.as_u16()))
    }

    /// The daemon closed the connection before it had answered.
    pub(crate) fn lost(&self) -> Failure {
        Failure::Lost { target: self.target() }
    }

    /// The reply has another shape than expected.
    pub(crate) fn misread(&self, why: String) -> Failure {
        Failure::Reply { target: self.target(), why }
    }

    fn refused(&self, mut reply: Value, status: u16) -> Failure {
        match serde_json::from_value::<Refusal>(reply["error"].take()) {
            Ok(refusal) => Failure::Refused(refusal),
            Err(_) => self.misread(format!("status {status} without an error")),
        }
    }

    async fn send(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Response<Incoming>, Failure> {
        let bytes = body.map_or_else(Bytes::new, |body| Bytes::from(body.to_string()));
        self.send_bytes(method, path, bytes, None).await
    }

    async fn send_bytes(
        &self,
        method: Method,
        path: &str,
        bytes: Bytes,
        after: Option<u64>,
    ) -> Result<Response<Incoming>, Failure> {
        let target = self.way()?;
        let mut request = Request::builder()
            .method(method)
            .uri(path)
            .header(header::HOST, "genomd")
            .header(header::CONTENT_TYPE, "application/json");
        if let Some(authorization) = target.authorization() {
            request = request.header(header::AUTHORIZATION, authorization);
        }
        if let Some(daemon) = &target.daemon {
            request = request.header("genomd-daemon", daemon);
        }
        if let Some(after) = after {
            request = request.header("last-event-id", after);
        }
        let request =
            request.body(Full::new(bytes)).map_err(|error| self.misread(error.to_string()))?;
        let stream = target.open().await?;
        let (mut sender, connection) = http1::handshake(TokioIo::new(stream))
            .await
            .map_err(|error| self.misread(error.to_string()))?;
        // It ends when the reply's body has been read or dropped.
        tokio::spawn(connection);
        sender.send_request(request).await.map_err(|error| {
            if error.is_parse() { self.misread(error.to_string()) } else { self.lost() }
        })
    }
}
