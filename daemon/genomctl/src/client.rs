//! HTTP/1.1 with JSON bodies to the daemon, over its Unix socket or TCP, or sealed through it to
//! another one (`far`).

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper::{Method, Request, header};
use hyper_util::rt::TokioIo;
use serde_json::Value;

use crate::body::Body;
use crate::connection::Connection;
use crate::contexts;
use crate::escape;
use crate::failure::{Failure, Refusal};
use crate::far::Far;
use crate::patience::Watch;
use crate::sse::EventStream;
use crate::target::Target;

/// A session that was not used for so long is begun anew: the daemon forgets them some time later.
const IDLE: Duration = Duration::from_secs(60);

/// A daemon to talk to. Each request is a connection of its own: queries are rare and short.
pub(crate) struct Client {
    given: Connection,
    /// The daemon behind the one at the socket, when that is meant, and when it was last asked.
    far: Mutex<Option<(Arc<Far>, Instant)>>,
}

impl std::fmt::Debug for Client {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.given.fmt(f)
    }
}

/// What came back.
pub(crate) struct Reply {
    /// As HTTP has it.
    pub(crate) status: u16,
    pub(crate) body: Body,
}

impl Reply {
    pub(crate) fn is_success(&self) -> bool {
        (200..300).contains(&self.status)
    }

    /// The whole reply as JSON; what was refused is a failure.
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

    /// Why it was refused.
    pub(crate) async fn refusal(self, target: &Target) -> Failure {
        let status = self.status;
        let bytes = match self.body.whole().await {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return target.lost(),
            Err(failure) => return failure,
        };
        let mut reply: Value = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
        // It is told on standard error, and in words.
        escape::all(&mut reply);
        match serde_json::from_value::<Refusal>(reply["error"].take()) {
            Ok(refusal) => Failure::Refused(refusal),
            Err(_) => target.misread(format!("status {status} without an error")),
        }
    }
}

impl Client {
    /// A client of the daemon that the command line names; nothing is read or opened yet, since
    /// verbs that talk to no daemon work whatever contexts and tokens there are.
    pub(crate) fn new(given: Connection) -> Self {
        Self { given, far: Mutex::default() }
    }

    fn way(&self) -> Result<Arc<Target>, Failure> {
        let (connection, chosen) = contexts::complete(self.given.clone())?;
        Target::new(connection, chosen).map(Arc::new)
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
        let (reply, target) = self.send(method, path, body).await?;
        reply.json(&target).await
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
        let (reply, target) = self.send_bytes(Method::GET, path, Bytes::new(), after).await?;
        match reply.is_success() {
            true => Ok(EventStream::new(reply.body)),
            false => Err(reply.refusal(&target).await),
        }
    }

    /// `POST` of bytes.
    pub(crate) async fn post_bytes(&self, path: &str, body: Vec<u8>) -> Result<Value, Failure> {
        let (reply, target) = self.send_bytes(Method::POST, path, body.into(), None).await?;
        reply.json(&target).await
    }

    /// Asks, and gives the reply's body as it comes.
    pub(crate) async fn open(
        &self,
        method: Method,
        path: &str,
        body: &Value,
    ) -> Result<Body, Failure> {
        let (reply, target) = self.send(method, path, Some(body)).await?;
        match reply.is_success() {
            true => Ok(reply.body),
            false => Err(reply.refusal(&target).await),
        }
    }

    /// The daemon closed the connection before it had answered.
    pub(crate) fn lost(&self) -> Failure {
        Failure::Lost { target: self.target() }
    }

    /// The reply has another shape than expected.
    pub(crate) fn misread(&self, why: String) -> Failure {
        Failure::Reply { target: self.target(), why }
    }

    async fn send(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<(Reply, Arc<Target>), Failure> {
        let bytes = body.map_or_else(Bytes::new, |body| Bytes::from(body.to_string()));
        self.send_bytes(method, path, bytes, None).await
    }

    async fn send_bytes(
        &self,
        method: Method,
        path: &str,
        bytes: Bytes,
        after: Option<u64>,
    ) -> Result<(Reply, Arc<Target>), Failure> {
        let target = self.way()?;
        let reply = match target.daemon.clone() {
            None => near(&target, method, path, bytes, after).await?,
            Some(daemon) => {
                let far = self.met(daemon).await?;
                far.request(method, path, &bytes, after).await?
            }
        };
        Ok((reply, target))
    }

    /// The session with a daemon behind this one.
    async fn met(&self, daemon: String) -> Result<Arc<Far>, Failure> {
        let kept = || self.far.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((far, used)) = kept().as_mut()
            && used.elapsed() < IDLE
        {
            *used = Instant::now();
            return Ok(Arc::clone(far));
        }
        let far = Arc::new(Far::meet(self.way()?, daemon).await?);
        *kept() = Some((Arc::clone(&far), Instant::now()));
        Ok(far)
    }
}

/// Asks the daemon that the way leads to.
pub(crate) async fn near(
    target: &Arc<Target>,
    method: Method,
    path: &str,
    bytes: Bytes,
    after: Option<u64>,
) -> Result<Reply, Failure> {
    let mut request = Request::builder()
        .method(method)
        .uri(path)
        .header(header::HOST, "genomd")
        .header(header::CONTENT_TYPE, "application/json");
    if let Some(authorization) = target.authorization() {
        request = request.header(header::AUTHORIZATION, authorization);
    }
    if let Some(after) = after {
        request = request.header("last-event-id", after);
    }
    let request =
        request.body(Full::new(bytes)).map_err(|error| target.misread(error.to_string()))?;
    let (stream, process) = target.open().await?;
    let watch = Watch::new(target, process);
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream))
        .await
        .map_err(|error| target.misread(error.to_string()))?;
    // It ends when the reply's body has been read or dropped.
    tokio::spawn(connection);
    let response = watch.over(sender.send_request(request)).await?.map_err(|error| {
        if error.is_parse() { target.misread(error.to_string()) } else { target.lost() }
    })?;
    Ok(Reply { status: response.status().as_u16(), body: Body::Near(response.into_body(), watch) })
}
