//! Makes requests to the daemon: over its Unix socket or TCP, or sealed through it to another
//! daemon (`far`).

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_protocol::routes::{self, Route, Stream};
use hyper::Method;
use hyper::body::Bytes;
use serde_json::Value;

use crate::body::Body;
use crate::connection::Connection;
use crate::contexts;
use crate::failure::Failure;
use crate::far::Far;
use crate::http::{self, Response};
use crate::sse::EventStream;
use crate::target::Target;

/// A session not used for this long is replaced by a new one: the daemon drops idle sessions some
/// time later.
const IDLE: Duration = Duration::from_secs(60);

/// A client of a daemon. Each request opens a connection of its own: requests are rare and short.
pub(crate) struct Client {
    given: Connection,
    /// The session with the daemon behind the one at the socket, if that is meant, and when it was
    /// last used.
    far: Mutex<Option<(Arc<Far>, Instant)>>,
}

impl std::fmt::Debug for Client {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.given.fmt(f)
    }
}

impl Client {
    /// A client of the daemon that the command line selects. Nothing is read or opened yet, because
    /// some verbs need no daemon and have to work whatever contexts and tokens there are.
    pub(crate) fn new(given: Connection) -> Self {
        Self { given, far: Mutex::default() }
    }

    fn way(&self) -> Result<Arc<Target>, Failure> {
        let (connection, chosen) = contexts::complete(self.given.clone())?;
        Target::new(connection, chosen).map(Arc::new)
    }

    /// The daemon, for messages.
    pub(crate) fn target(&self) -> String {
        self.way().map_or_else(|_| "?".to_owned(), |target| target.to_string())
    }

    /// Makes a request and waits for the whole reply. The caller reads it as the type `R` of the
    /// route.
    pub(crate) async fn request<R, Q, B>(
        &self,
        route: &Route<R, Q, B>,
        body: Vec<u8>,
    ) -> Result<Value, Failure> {
        let (response, target) = self.send(route, body.into(), None).await?;
        response.json(&target).await
    }

    /// Opens a stream of server-sent events.
    pub(crate) async fn stream<T, Q>(
        &self,
        route: &Route<Stream<T>, Q>,
    ) -> Result<EventStream, Failure> {
        self.resume(route, None).await
    }

    /// Resumes a stream that broke, after the event of that number.
    pub(crate) async fn resume<T, Q>(
        &self,
        route: &Route<Stream<T>, Q>,
        after: Option<u64>,
    ) -> Result<EventStream, Failure> {
        let (response, target) = self.send(route, Bytes::new(), after).await?;
        match response.is_success() {
            true => Ok(EventStream::new(response.body)),
            false => Err(response.refusal(&target).await),
        }
    }

    /// Makes a request, and returns the reply's body as a stream.
    pub(crate) async fn open<Q, B>(
        &self,
        route: &Route<routes::Bytes, Q, B>,
        body: Vec<u8>,
    ) -> Result<Body, Failure> {
        let (response, target) = self.send(route, body.into(), None).await?;
        match response.is_success() {
            true => Ok(response.body),
            false => Err(response.refusal(&target).await),
        }
    }

    /// The daemon closed the connection before it replied.
    pub(crate) fn lost(&self) -> Failure {
        Failure::Lost { target: self.target() }
    }

    /// The reply does not have the expected form.
    pub(crate) fn misread(&self, why: String) -> Failure {
        Failure::Reply { target: self.target(), why }
    }

    async fn send<R, Q, B>(
        &self,
        route: &Route<R, Q, B>,
        bytes: Bytes,
        after: Option<u64>,
    ) -> Result<(Response, Arc<Target>), Failure> {
        let (method, path) = (method(route.method), route.path.as_str());
        let target = self.way()?;
        let response = match target.daemon.clone() {
            None => http::ask(&target, method, path, bytes, after).await?,
            Some(daemon) => {
                let far = self.met(daemon).await?;
                far.request(method, path, &bytes, after).await?
            }
        };
        Ok((response, target))
    }

    /// The session with the daemon behind this one, established if needed.
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

fn method(of: routes::Method) -> Method {
    match of {
        routes::Method::Get => Method::GET,
        routes::Method::Put => Method::PUT,
        routes::Method::Post => Method::POST,
        routes::Method::Delete => Method::DELETE,
    }
}
