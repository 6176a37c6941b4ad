//! The session: opens, shows and closes ends; knows who is there.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::thread;

use genom_middleware::describe::{type_of_port, types_of_service};
use genom_middleware::mailbox::{Full, MAX_DEPTH, Mailbox};
use genom_middleware::spares::Spares;
use genom_middleware::{
    Address, Capabilities, Client, DiscoverError, Endpoint, EndpointKind, Middleware, OpenError,
    Policy, Publisher, Relay, Served, ServiceHandler, ServiceKind, ServiceType, Stranger,
    Subscription,
};
use genom_types::{DataType, Record};
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::qos::CongestionControl;
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use crate::client::ZenohClient;
use crate::graph::{Claim, Graph};
use crate::inbox::Inbox;
use crate::keys::{Keys, Token};
use crate::options::{Options, SessionError};
use crate::ports::{ZenohPublisher, ZenohSubscription};
use crate::relay::Daemons;
use crate::rendezvous::{self, Rendezvous};
use crate::service::{Server, ZenohServed};
use crate::wire::{self, Expected, Mark};
use crate::worker::{LastValue, Line, Orders, Worker};

/// The name of this middleware.
pub(crate) const BACKEND: &str = "zenoh";

/// Unsent samples kept per out port, and the bytes they may take: then fewer are.
const UNSENT: usize = 16;
const UNSENT_BYTES: usize = 1 << 20;

/// A session on zenoh, as middleware.
pub struct Zenoh {
    pub(crate) core: Arc<Core>,
}

/// What all ends share. Closed with the last of them.
pub(crate) struct Core {
    session: Session,
    /// Where others meet it.
    meeting: Vec<(&'static str, String)>,
    keys: Keys,
    graph: Arc<Graph>,
    daemons: Arc<Daemons>,
    worker: Option<Worker>,
    /// This session's name in tokens.
    name: String,
    /// Its files are removed last.
    _rendezvous: Option<Rendezvous>,
    orders: Orders,
}

/// Runs what zenoh refuses to do within a single-threaded tokio runtime, whoever calls.
fn apart<R: Send>(run: impl FnOnce() -> R + Send) -> Option<R> {
    thread::scope(|scope| scope.spawn(run).join().ok())
}

impl Zenoh {
    /// Opens a session. It may take half a second when an endpoint to connect to is not there.
    ///
    /// # Errors
    /// An option is wrong, or zenoh does not open.
    pub fn open(options: &Options) -> Result<Arc<Self>, SessionError> {
        let prefix = options.prefix.trim_matches('/');
        let keys = Keys::new(prefix);
        if !prefix.is_empty()
            && (prefix.contains(['*', '$', '@']) || OwnedKeyExpr::new(prefix).is_err())
        {
            return Err(SessionError::Prefix(prefix.to_owned()));
        }
        let (rendezvous, session) = match options.meeting() {
            None => (None, open(options, options.to_zenoh(None, &[])?)?),
            Some(directory) => {
                let entered = Rendezvous::enter(directory).map_err(|source| {
                    SessionError::Rendezvous { path: directory.to_owned(), source }
                })?;
                let (own, opening) = entered;
                let config = options.to_zenoh(Some(own.socket()), &opening.others)?;
                let session = open(options, config)?;
                (Some(own), session)
            }
        };
        let failed = |error: &dyn std::fmt::Display| SessionError::Open(error.to_string());
        let worker = Worker::start(session.clone()).map_err(|error| failed(&error))?;
        // What a client of this session's connects to.
        let own = rendezvous.iter().map(|own| rendezvous::endpoint(own.socket()));
        let connect: Vec<String> = own.chain(options.listen.iter().cloned()).collect();
        let mut meeting = vec![("prefix", keys.of_all().to_owned())];
        if !connect.is_empty() {
            meeting.push(("connect", connect.join(",")));
        }
        if let Some(directory) = options.sole_meeting() {
            meeting.push(("rendezvous", directory.display().to_string()));
        }
        let core = Arc::new(Core {
            meeting,
            keys,
            graph: Arc::default(),
            daemons: Arc::default(),
            name: session.zid().to_string(),
            _rendezvous: rendezvous,
            orders: worker.orders.clone(),
            worker: Some(worker),
            session,
        });
        core.watch().map_err(|error| failed(&error))?;
        Ok(Arc::new(Self { core }))
    }

    /// Keeps the sending thread from its work until the result is dropped: for tests of what
    /// real-time callers feel of a stalled network.
    #[doc(hidden)]
    #[must_use]
    pub fn stall(&self) -> impl Send + use<> {
        let (release, held) = std::sync::mpsc::channel::<()>();
        self.core.orders.submit(move |_| {
            let _ = held.recv();
        });
        release
    }
}

fn open(options: &Options, config: zenoh::Config) -> Result<Session, SessionError> {
    let opened = apart(|| zenoh::open(config).wait().map_err(|error| error.to_string()));
    let opened = opened.unwrap_or_else(|| Err("it panicked; see standard error".to_owned()));
    let secret = options.connect.iter().any(|endpoint| endpoint.starts_with("tls/"));
    opened.map_err(if secret { SessionError::Refused } else { SessionError::Open })
}

impl Drop for Core {
    fn drop(&mut self) {
        self.worker = None;
        let session = &self.session;
        if let Some(Err(error)) = apart(|| session.close().wait()) {
            tracing::warn!(%error, "zenoh did not close");
        }
    }
}

impl Core {
    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn orders(&self) -> &Orders {
        &self.orders
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.graph
    }

    pub(crate) fn daemons(&self) -> &Daemons {
        &self.daemons
    }

    pub(crate) fn keys(&self) -> &Keys {
        &self.keys
    }

    /// This session's name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Follows the tokens of others. Those that are there already are seen before this returns.
    fn watch(&self) -> zenoh::Result<()> {
        let (graph, keys, own) = (Arc::clone(&self.graph), self.keys.clone(), self.name.clone());
        let (orders, daemons) = (self.orders.clone(), Arc::clone(&self.daemons));
        let news = move |sample: zenoh::sample::Sample| {
            if let Some((session, name)) = keys.daemon(sample.key_expr().as_str()) {
                return daemons.heard(session, name, sample.kind() == SampleKind::Put, &own);
            }
            let token = keys.token(sample.key_expr().as_str());
            let Some(token) = token.filter(|token| token.session != own) else { return };
            if sample.kind() == SampleKind::Delete {
                return graph.vanished(&token);
            }
            let Some(at) = Address::parse(&token.address) else { return };
            for inbox in graph.appeared(token) {
                if let Ok(key) = keys.of(&at) {
                    orders.submit(move |outgoing| ask(&outgoing.session, &key, inbox));
                }
            }
        };
        let liveliness = self.session.liveliness();
        let watch = liveliness.declare_subscriber(self.keys.all_tokens());
        watch.history(true).callback(news).background().wait()
    }

    fn failed(&self, at: &Address, why: impl std::fmt::Display) -> OpenError {
        OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why: why.to_string() }
    }

    fn key(&self, at: &Address) -> Result<OwnedKeyExpr, OpenError> {
        self.keys.of(at).map_err(|why| self.failed(at, why))
    }

    /// Claims an address; others see it once it is [`shown`](Core::show).
    fn claim(
        &self,
        at: &Address,
        kind: EndpointKind,
        digest: String,
        types: String,
    ) -> Result<Claim, OpenError> {
        let token = Token {
            kind,
            session: self.name.clone(),
            number: 0,
            digest,
            types,
            address: at.to_string(),
        };
        self.graph.claim(at, token)
    }

    fn show(&self, at: &Address, claim: Claim) -> Result<Claim, OpenError> {
        let key = self.keys.of_token(claim.token());
        let token = self.session.liveliness().declare_token(key).wait();
        Ok(claim.declared(token.map_err(|error| self.failed(at, error))?))
    }

    fn claim_port(
        &self,
        at: &Address,
        kind: EndpointKind,
        ty: &DataType,
    ) -> Result<Claim, OpenError> {
        self.claim(at, kind, ty.digest().to_owned(), type_of_port(ty))
    }
}

/// Asks the writers of a port for its last value.
fn ask(session: &Session, key: &OwnedKeyExpr, inbox: Arc<Inbox>) {
    let asked = inbox.ask();
    let get = session.get(key).target(QueryTarget::All).consolidation(ConsolidationMode::None);
    let get = get.callback(move |reply| {
        if let Ok(sample) = reply.result() {
            inbox.arrive(sample, Some(&asked));
        }
    });
    if let Err(error) = get.wait() {
        tracing::warn!(%key, %error, "zenoh does not ask for the last value");
    }
}

/// Room for a message of the type, without allocation later as far as it can be told: CDR is
/// seldom larger than the C layout, and never four times as large.
fn room(ty: &DataType) -> usize {
    let size = ty.size();
    if size <= 1 << 16 { size * 4 + 64 } else { size + size / 4 }
}

/// Differs between any two writers of a session, and as good as surely between all.
fn new_writer() -> u64 {
    RandomState::new().hash_one(thread::current().id())
}

impl Middleware for Zenoh {
    fn name(&self) -> &'static str {
        BACKEND
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: true,
            cross_host: true,
            services: true,
            native_services: true,
        }
    }

    fn meeting_point(&self) -> Vec<(&'static str, String)> {
        self.core.meeting.clone()
    }

    fn publisher(&self, at: &Address, ty: &DataType) -> Result<Box<dyn Publisher>, OpenError> {
        let core = &self.core;
        ty.prepare();
        let key = core.key(at)?;
        let claim = core.claim_port(at, EndpointKind::Publisher, ty)?;
        let failed = |error| core.failed(at, error);
        let encoding = wire::encoding_of(ty);
        let last = Arc::new(LastValue::default());
        let offered = {
            let (last, key, encoding) = (Arc::clone(&last), key.clone(), encoding.clone());
            move |query: zenoh::query::Query| {
                let Some((payload, mark)) = last.get() else { return };
                let reply = query.reply(key.clone(), payload).encoding(encoding.clone());
                if let Err(error) = reply.attachment(&mark.to_bytes()[..]).wait() {
                    tracing::debug!(%key, %error, "the last value was not sent");
                }
            }
        };
        let queryable = core.session.declare_queryable(key.clone()).callback(offered);
        let queryable = queryable.wait().map_err(failed)?;
        let publisher = core
            .session
            .declare_publisher(key)
            .encoding(encoding)
            // A reader that does not keep up holds back the sending thread, not the writers:
            // they lose old samples, and the last one arrives.
            .congestion_control(CongestionControl::Block)
            .wait()
            .map_err(failed)?;
        let room = room(ty);
        let depth = (UNSENT_BYTES / room.max(1)).clamp(1, UNSENT);
        let mailbox = Arc::new(Mailbox::new(depth, room, Full::Oldest));
        let refused = Arc::new(AtomicU64::new(0));
        // The token comes last: who sees it can ask for the last value.
        let claim = core.show(at, claim)?;
        let line = core.orders.add(Line {
            publisher,
            mailbox: Arc::clone(&mailbox),
            spares: Spares::new(room),
            last,
            mark: Mark { writer: new_writer(), number: 0 },
            refused: Arc::clone(&refused),
        });
        Ok(Box::new(ZenohPublisher {
            ty: ty.clone(),
            mailbox,
            refused,
            line,
            shown: Some((queryable, claim)),
            core: Arc::clone(core),
        }))
    }

    fn subscription(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let core = &self.core;
        let full = match policy {
            Policy::Latest => (1, Full::Oldest),
            Policy::Queue(depth) => (depth, Full::Newest),
            Policy::Ring(depth) => (depth, Full::Oldest),
        };
        if full.0 > MAX_DEPTH {
            return Err(OpenError::Unsupported {
                backend: BACKEND.to_owned(),
                ty: ty.name().to_owned(),
                why: format!("a reader holds at most {MAX_DEPTH} samples, not {}", full.0),
            });
        }
        ty.prepare();
        let key = core.key(at)?;
        let claim = core.claim_port(at, EndpointKind::Subscription, ty)?;
        let expected = Expected::of(ty);
        let latest = policy == Policy::Latest;
        let inbox = Inbox::new(at.to_string(), expected, full, ty.size() + 64, latest);
        let inbox = Arc::new(inbox);
        let arriving = Arc::clone(&inbox);
        let subscriber = core.session.declare_subscriber(key.clone());
        let subscriber = subscriber.callback(move |sample| arriving.arrive(&sample, None));
        let subscriber = subscriber.wait().map_err(|error| core.failed(at, error))?;
        let claim = core.show(at, claim)?;
        // Writers that come later are asked when they do.
        core.graph.add_reader(at, &inbox);
        ask(&core.session, &key, Arc::clone(&inbox));
        Ok(Box::new(ZenohSubscription {
            scratch: Record::new(ty),
            inbox,
            read: false,
            _subscriber: subscriber,
            _claim: claim,
            _core: Arc::clone(core),
        }))
    }

    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let core = &self.core;
        let key = core.key(at)?;
        let digest = service.digest();
        let types = types_of_service(service);
        let claim = core.claim(at, EndpointKind::Service, digest, types)?;
        let orders = core.orders.clone();
        let server = Arc::new(Server::new(service.clone(), handler, orders));
        // A question to all keys is no request to this one.
        let declare = |key: OwnedKeyExpr, act: fn(&Server, zenoh::query::Query)| {
            let server = Arc::clone(&server);
            let queryable = core.session.declare_queryable(key.clone()).complete(true);
            queryable
                .callback(move |query| {
                    if query.key_expr().as_str() == key.as_str() {
                        act(&server, query);
                    }
                })
                .wait()
                .map_err(|error| core.failed(at, error))
        };
        let cancel = (service.kind == ServiceKind::Activity)
            .then(|| declare(core.key(&cancel_of(at))?, Server::cancel))
            .transpose()?;
        let queryable = declare(key, Server::request)?;
        let claim = core.show(at, claim)?;
        let shown = Some((queryable, cancel, claim));
        Ok(Box::new(ZenohServed { server, shown, core: Arc::clone(core) }))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let core = &self.core;
        let digest = service.digest();
        if let Some(theirs) = core.graph.other_service(&at.to_string(), &digest) {
            let ours = types_of_service(service);
            return Err(OpenError::TypeMismatch { address: at.clone(), ours, theirs });
        }
        Ok(Box::new(ZenohClient {
            key: core.key(at)?,
            cancel: core.key(&cancel_of(at))?,
            at: at.clone(),
            ty: service.clone(),
            core: Arc::clone(core),
        }))
    }

    fn relay(&self) -> Option<&dyn Relay> {
        Some(self)
    }

    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        Ok(self.core.graph.list())
    }

    fn strangers(&self) -> Vec<Stranger> {
        self.core.strangers()
    }
}

/// Where an activity is cancelled.
fn cancel_of(at: &Address) -> Address {
    Address::new(at.instance.as_str(), format!("{}/cancel", at.name))
}
