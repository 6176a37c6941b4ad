//! What all ends of a session share: its sending thread, and the other ends that it sees.

use std::fmt::Display;
use std::sync::Arc;
use std::thread;

use genom_kit::sender::Sender;
use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, EndpointKind, OpenError};
use genom_types::DataType;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use crate::daemons::Daemons;
use crate::error::{BACKEND, SessionError};
use crate::graph::{Claim, Graph};
use crate::inbox::Inbox;
use crate::keys::{Keys, Token};
use crate::rendezvous::Rendezvous;
use crate::sending::{Orders, Outgoing};

/// What all ends share. The session closes when the last one is dropped.
pub(crate) struct Core {
    session: Session,
    /// What it was opened with, without the sessions that it met.
    config: zenoh::Config,
    keys: Keys,
    graph: Arc<Graph>,
    daemons: Arc<Daemons>,
    sender: Option<Sender<Outgoing>>,
    /// Name of this session in liveliness tokens.
    name: String,
    /// Its files are removed last.
    rendezvous: Option<Rendezvous>,
    orders: Orders,
}

/// Runs `run` on a separate thread, since zenoh refuses some calls within a single-threaded tokio
/// runtime.
pub(crate) fn apart<R: Send>(run: impl FnOnce() -> R + Send) -> Option<R> {
    thread::scope(|scope| scope.spawn(run).join().ok())
}

impl Drop for Core {
    fn drop(&mut self) {
        self.sender = None;
        let session = &self.session;
        if let Some(Err(error)) = apart(|| session.close().wait()) {
            tracing::warn!(%error, "zenoh did not close");
        }
    }
}

impl Core {
    /// Starts the sending thread, and begins to watch for ends of other sessions.
    pub(crate) fn new(
        (session, config): (Session, zenoh::Config),
        keys: Keys,
        rendezvous: Option<Rendezvous>,
    ) -> Result<Arc<Self>, SessionError> {
        let failed = |error: &dyn Display| SessionError::Open(error.to_string());
        let sender = Sender::start("zenoh", true, Outgoing { session: session.clone() });
        let sender = sender.map_err(|error| failed(&error))?;
        let core = Arc::new(Self {
            config,
            keys,
            graph: Arc::default(),
            daemons: Arc::default(),
            name: session.zid().to_string(),
            rendezvous,
            orders: sender.orders().clone(),
            sender: Some(sender),
            session,
        });
        core.watch().map_err(|error| failed(&error))?;
        Ok(core)
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn config(&self) -> &zenoh::Config {
        &self.config
    }

    /// Whether it finds others by their sockets in a folder.
    pub(crate) fn meets(&self) -> bool {
        self.rendezvous.is_some()
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

    /// Name of this session.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Watches the liveliness tokens of others. Returns after those that exist already were seen.
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
                    orders.submit(move |outgoing, _| ask(&outgoing.session, &key, inbox));
                }
            }
        };
        let liveliness = self.session.liveliness();
        let watch = liveliness.declare_subscriber(self.keys.all_tokens());
        watch.history(true).callback(news).background().wait()
    }

    pub(crate) fn failed(&self, at: &Address, why: impl std::fmt::Display) -> OpenError {
        OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why: why.to_string() }
    }

    pub(crate) fn key(&self, at: &Address) -> Result<OwnedKeyExpr, OpenError> {
        self.keys.of(at).map_err(|why| self.failed(at, why))
    }

    /// Claims an address. Others see it after [`show`](Core::show).
    pub(crate) fn claim(
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

    pub(crate) fn show(&self, at: &Address, claim: Claim) -> Result<Claim, OpenError> {
        let key = self.keys.of_token(claim.token());
        let token = self.session.liveliness().declare_token(key).wait();
        Ok(claim.declared(token.map_err(|error| self.failed(at, error))?))
    }

    pub(crate) fn claim_port(
        &self,
        at: &Address,
        kind: EndpointKind,
        ty: &DataType,
    ) -> Result<Claim, OpenError> {
        self.claim(at, kind, ty.digest().to_owned(), type_of_port(ty))
    }
}

/// Queries the writers of a port for its last value.
pub(crate) fn ask(session: &Session, key: &OwnedKeyExpr, inbox: Arc<Inbox>) {
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
