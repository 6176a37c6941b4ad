//! HTTP/1.1 with JSON bodies to the daemon, over its Unix socket or loopback TCP.

use std::path::PathBuf;

use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1;
use hyper::{Method, Request, Response, header};
use hyper_util::rt::TokioIo;
use serde_json::Value;
use tokio::net::{TcpStream, UnixStream};

use crate::args::Connection;
use crate::failure::{Failure, Refusal};
use crate::sse::EventStream;

/// A daemon to talk to. Each request is a connection of its own: queries are rare and short.
#[derive(Debug)]
pub(crate) struct Client {
    target: Target,
}

#[derive(Debug)]
enum Target {
    Socket(PathBuf),
    Tcp(std::net::SocketAddr),
}

impl std::fmt::Display for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Target::Socket(path) => write!(f, "{}", path.display()),
            Target::Tcp(address) => write!(f, "{address}"),
        }
    }
}

impl Client {
    /// A client of the daemon that the command line names.
    pub(crate) fn new(connection: Connection) -> Self {
        let target = match (connection.host, connection.socket) {
            (Some(address), _) => Target::Tcp(address),
            (None, Some(path)) => Target::Socket(path),
            (None, None) => Target::Socket(default_socket()),
        };
        Self { target }
    }

    /// Who is talked to, for messages.
    pub(crate) fn target(&self) -> String {
        self.target.to_string()
    }

    /// Asks, and waits for the whole reply.
    pub(crate) async fn request(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Value, Failure> {
        let response = self.send(method, path, body).await?;
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
        let response = self.send(Method::GET, path, None).await?;
        let status = response.status();
        if status.is_success() {
            return Ok(EventStream::new(response.into_body()));
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
        let request = Request::builder()
            .method(method)
            .uri(path)
            .header(header::HOST, "genomd")
            .header(header::CONTENT_TYPE, "application/json")
            .body(Full::new(bytes))
            .map_err(|error| self.misread(error.to_string()))?;
        let unreachable = |source| Failure::Unreachable { target: self.target.to_string(), source };
        match &self.target {
            Target::Socket(path) => {
                let stream = UnixStream::connect(path).await.map_err(unreachable)?;
                self.exchange(TokioIo::new(stream), request).await
            }
            Target::Tcp(address) => {
                let stream = TcpStream::connect(address).await.map_err(unreachable)?;
                self.exchange(TokioIo::new(stream), request).await
            }
        }
    }

    async fn exchange<S>(
        &self,
        stream: S,
        request: Request<Full<Bytes>>,
    ) -> Result<Response<Incoming>, Failure>
    where
        S: hyper::rt::Read + hyper::rt::Write + Unpin + Send + 'static,
    {
        let (mut sender, connection) =
            http1::handshake(stream).await.map_err(|error| self.misread(error.to_string()))?;
        // It ends when the reply's body has been read or dropped.
        tokio::spawn(connection);
        sender.send_request(request).await.map_err(|error| {
            if error.is_parse() { self.misread(error.to_string()) } else { self.lost() }
        })
    }
}

/// Where a daemon of this user listens when nothing else is said; `genomd` has the same rule.
fn default_socket() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR").filter(|dir| !dir.is_empty()) {
        Some(dir) => PathBuf::from(dir).join("genomd.sock"),
        None => {
            let user = rustix::process::getuid().as_raw();
            PathBuf::from(format!("/tmp/genomd-{user}/genomd.sock"))
        }
    }
}
