//! A service: the serving end is a queryable, the calling end queries it.

use std::sync::atomic::{AtomicI64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_middleware::CallError;
use zenoh::bytes::ZBytes;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable, Reply as Answered};
use zenoh::{Session, Wait};

use super::attachment::Attachment;
use super::core::{Core, Shown};
use super::graph::Graph;
use super::keys::{self, Kind};
use super::quality::Quality;
use super::refusals::Reason;
use super::sending::Orders;
use crate::error::BACKEND;
use crate::lock::lock;
use crate::rmw::{
    Answer, ClientEnd, EndError, Entities, Gid, Named, OnRequest, Reply, ServerEnd, Target,
};

/// Time after which a reply is lost. zenoh keeps a timer for each query for this long, even after
/// the reply, so it is short for frequent calls.
const ANSWER: Duration = Duration::from_secs(60);

/// The same for results of actions: the longest run whose end is reported.
const RUN: Duration = Duration::from_secs(7 * 24 * 3600);

/// Number of requests of a service that may wait for their replies. Results of actions are waited
/// for as long as these run.
const OPEN: usize = 1024;

/// Header of a message in CDR, little endian.
const LITTLE: [u8; 4] = [0, 1, 0, 0];

/// A message of this body.
pub(crate) fn message(body: &[u8]) -> Vec<u8> {
    [&LITTLE, body].concat()
}

/// The serving end.
pub(crate) struct Server {
    gid: Gid,
    /// Dropped in order, so that nobody calls what is gone.
    shown: Mutex<Option<(Shown, Queryable<()>)>>,
    orders: Orders,
}

/// Counts a request that waits for its reply.
struct Open(Arc<AtomicUsize>);

impl Open {
    /// `None` if there are too many.
    fn new(count: &Arc<AtomicUsize>) -> Option<Self> {
        let open = Self(Arc::clone(count));
        // One too many is counted until `open` is dropped.
        (count.fetch_add(1, Ordering::AcqRel) < OPEN).then_some(open)
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Where the reply to one query goes. Dropping it ends the query.
struct ToClient {
    query: Query,
    open: Open,
    request: Attachment,
    orders: Orders,
}

impl Reply for ToClient {
    fn send(self: Box<Self>, body: Vec<u8>) {
        let Self { query, open, request, orders } = *self;
        orders.submit(move |_, _| {
            let _open = open;
            let reply = query.reply(query.key_expr().clone(), message(&body));
            // Number and client as in the request.
            if let Err(error) = reply.attachment(&request.encode()[..]).wait() {
                // The client may be gone, which is not an error here.
                tracing::debug!(%error, "a reply was not sent");
            }
        });
    }

    fn asker(&self) -> Gid {
        self.request.gid
    }
}

impl Server {
    pub(crate) fn open(
        core: &Core,
        node: &str,
        of: &Named,
        on_request: OnRequest,
    ) -> Result<Self, EndError> {
        let key = keys::of(core.domain, of)?;
        let draft = core.draft(node, Kind::Server, of, Quality::SERVICE)?;
        let orders = core.orders().clone();
        let answering = orders.clone();
        let (open, refusals) = (Arc::<AtomicUsize>::default(), Arc::clone(&core.refusals));
        let asked = move |query: Query| {
            let refuse = |why| refusals.add(why, query.key_expr().as_str());
            // A plain zenoh program attaches nothing.
            let plain = Attachment { number: 0, gid: Gid::default() };
            let request = query.attachment().map_or(Some(plain), Attachment::decode);
            let Some(request) = request else { return refuse(Reason::Attachment) };
            let Some(open) = Open::new(&open) else { return refuse(Reason::Requests) };
            let message = query.payload().map(ZBytes::to_bytes).unwrap_or_default().into_owned();
            let orders = answering.clone();
            on_request(Box::new(ToClient { query, open, request, orders }), &message);
        };
        let queryable = core.session().declare_queryable(key).complete(true).callback(asked);
        let queryable = queryable.wait()?;
        // Its token is declared last, so that who sees it can call it.
        let shown = core.show(&draft)?;
        Ok(Self { gid: draft.gid, shown: Mutex::new(Some((shown, queryable))), orders })
    }
}

impl ServerEnd for Server {
    fn entities(&self) -> Entities {
        Entities { writers: Vec::new(), readers: vec![self.gid] }
    }

    fn withdraw(&self) {
        let shown = lock(&self.shown).take();
        drop(shown);
    }

    fn flush(&self) {
        self.orders.finish(|_, _| {});
    }
}

/// The calling end.
pub(crate) struct Caller {
    gid: Gid,
    domain: u16,
    name: String,
    /// The key of its own type, for servers that are not known.
    key: OwnedKeyExpr,
    graph: Arc<Graph>,
    timeout: Duration,
    /// Number of the last request.
    last: AtomicI64,
    orders: Orders,
    _shown: Shown,
}

impl Caller {
    pub(crate) fn open(core: &Core, node: &str, of: &Named) -> Result<Self, EndError> {
        let key = keys::of(core.domain, of)?;
        let draft = core.draft(node, Kind::Client, of, Quality::SERVICE)?;
        let runs = of.name.ends_with("/_action/get_result");
        Ok(Self {
            gid: draft.gid,
            domain: core.domain,
            name: of.name.clone(),
            key,
            graph: Arc::clone(&core.graph),
            timeout: if runs { RUN } else { ANSWER },
            last: AtomicI64::new(0),
            orders: core.orders().clone(),
            _shown: core.show(&draft)?,
        })
    }
}

impl Caller {
    /// The key of the server: that of its type, which may have another name than the caller's.
    fn key(&self, to: Target) -> OwnedKeyExpr {
        let (Target::End(of) | Target::Beside(of)) = to;
        let server = self.graph.server(&self.name, of);
        let key =
            server.and_then(|(ty, hash)| keys::of_found(self.domain, &self.name, &ty, &hash).ok());
        key.unwrap_or_else(|| self.key.clone())
    }
}

/// Owned by zenoh's callback, which is dropped when no more replies can come: the answer is that
/// the server is gone, then.
struct Waiting {
    answer: Mutex<Option<Answer>>,
    timeout: Duration,
}

impl Waiting {
    fn hear(&self, reply: Answered) {
        let Some(answer) = lock(&self.answer).take() else { return };
        match reply.into_result() {
            Ok(sample) => answer.give(Ok(&sample.payload().to_bytes())),
            Err(error) => {
                let why = error.payload().to_bytes();
                answer.give(Err(match &*why {
                    b"Timeout" => CallError::Timeout(self.timeout),
                    why => CallError::Failed {
                        backend: BACKEND.to_owned(),
                        why: String::from_utf8_lossy(why).into_owned(),
                    },
                }));
            }
        }
    }
}

fn ask(
    session: &Session,
    key: &OwnedKeyExpr,
    body: &[u8],
    request: Attachment,
    waiting: Arc<Waiting>,
) -> zenoh::Result<()> {
    let timeout = waiting.timeout;
    session
        .get(key)
        .payload(message(body))
        .attachment(&request.encode()[..])
        .target(QueryTarget::AllComplete)
        .consolidation(ConsolidationMode::None)
        .timeout(timeout)
        .callback(move |reply| waiting.hear(reply))
        .wait()
}

impl ClientEnd for Caller {
    // All servers of the name get it; the first reply counts.
    fn call(&self, to: Target, body: Vec<u8>, answer: Answer) {
        let number = self.last.fetch_add(1, Ordering::Relaxed) + 1;
        let request = Attachment { number, gid: self.gid };
        let (key, timeout) = (self.key(to), self.timeout);
        // On the sending thread, because this may be called within a callback of zenoh.
        self.orders.submit(move |outgoing, _| {
            let waiting = Arc::new(Waiting { answer: Mutex::new(Some(answer)), timeout });
            let asked = ask(&outgoing.session, &key, &body, request, Arc::clone(&waiting));
            if let Err(error) = asked
                && let Some(answer) = lock(&waiting.answer).take()
            {
                let why = error.to_string();
                answer.give(Err(CallError::Failed { backend: BACKEND.to_owned(), why }));
            }
        });
    }
}
