//! What all ends share: the session, its sending thread, and the graph of known ends.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Weak};

use genom_kit::sender::Sender;
use zenoh::liveliness::LivelinessToken;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Config, Session, Wait};

use super::graph::Graph;
use super::keys::{self, End, Id, Kind, Node};
use super::quality::Quality;
use super::readers::Readers;
use super::refusals::{Reason, Refusals};
use super::router::Router;
use super::sending::{Orders, Outgoing};
use super::session::{Settings, apart, open};
use super::told::{self, Told};
use crate::domain::Domain;
use crate::error::ParticipantError;
use crate::lock::lock;
use crate::names;
use crate::options::{Options, Qos};
use crate::rmw::{EndError, Gid, Named};

/// Kept alive by ports and services.
pub(crate) struct Core {
    session: Session,
    /// What it was opened with.
    pub(crate) config: Config,
    pub(crate) domain: u16,
    pub(crate) qos: Qos,
    pub(crate) graph: Arc<Graph>,
    pub(crate) readers: Arc<Readers>,
    pub(crate) refusals: Arc<Refusals>,
    /// By name.
    nodes: Mutex<HashMap<String, Weak<NodeShown>>>,
    /// Numbers of services that were told of before they exist, by name.
    claimed: Mutex<HashMap<String, u64>>,
    /// Numbers nodes and ends.
    next: AtomicU64,
    sender: Option<Sender<Outgoing>>,
    orders: Orders,
    /// Name of the session in tokens.
    pub(crate) zid: String,
    /// Closed last.
    _router: Arc<Router>,
}

/// Keeps a node known to others.
pub(crate) struct NodeShown {
    node: Node,
    _token: LivelinessToken,
}

/// An end that is to be shown.
pub(crate) struct Draft {
    end: End,
    node: Arc<NodeShown>,
    token: String,
    pub(crate) gid: Gid,
}

impl Draft {
    fn of(end: End, node: Arc<NodeShown>, domain: u16) -> Self {
        let token = end.token(domain);
        let gid = keys::gid(&token);
        Self { end, node, token, gid }
    }

    /// The same end, which reads [`keys::of_buffers`], too.
    pub(crate) fn with_buffers(self, domain: u16) -> Self {
        Self::of(End { buffers: true, ..self.end }, self.node, domain)
    }
}

/// Keeps an end known to others. Fields are dropped in order: of a daemon's end, what only daemons
/// know is told for longer than the end is there.
pub(crate) struct Shown {
    _token: LivelinessToken,
    _node: Arc<NodeShown>,
}

impl Draft {
    pub(crate) fn id(&self) -> Id {
        self.end.id()
    }
}

impl Core {
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        let domain = Domain::of(options)?;
        let settings = Settings::of(options, &domain.networks)?;
        let router = Arc::new(Router::new(settings.router));
        router.run();
        let config = settings.session;
        let session = open(config.clone())?;
        let sender = Sender::start(
            "ros2",
            true,
            Outgoing { session: session.clone(), router: Arc::clone(&router) },
        )?;
        let core = Arc::new(Self {
            domain: domain.number,
            qos: options.qos,
            graph: Arc::new(Graph::new(options.participants)),
            readers: Arc::default(),
            refusals: Arc::new(Refusals::of_samples_above(options.greatest_sample as usize)),
            nodes: Mutex::default(),
            claimed: Mutex::default(),
            next: AtomicU64::new(0),
            orders: sender.orders().clone(),
            sender: Some(sender),
            zid: session.zid().to_string(),
            config,
            session,
            _router: Arc::clone(&router),
        });
        let failed = |error: zenoh::Error| ParticipantError::Zenoh(error.to_string());
        core.watch().map_err(failed)?;
        core.watch_router(&router).map_err(failed)?;
        Ok(core)
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn orders(&self) -> &Orders {
        &self.orders
    }

    /// Watches the tokens of others. What daemons tell each other is watched first: of each end it
    /// is declared first, so it is usually known here when the end is.
    fn watch(&self) -> zenoh::Result<()> {
        let (graph, own, follow) = (Arc::clone(&self.graph), self.zid.clone(), self.follower());
        let refusals = Arc::clone(&self.refusals);
        let heard = move |sample: Sample| {
            let key = sample.key_expr().as_str();
            let there = sample.kind() == SampleKind::Put;
            match Told::parse(key) {
                Some((id, _)) if id.0 == own => {}
                Some((id, _)) if !there => graph.untold(&id),
                Some((id, told)) => match graph.told(id, told) {
                    Ok(name) => follow(name),
                    Err(why) => refusals.add(why, key),
                },
                None if there => refusals.add(Reason::Token, key),
                None => {}
            }
        };
        let liveliness = self.session.liveliness();
        let watch = liveliness.declare_subscriber(told::all_tokens(self.domain)).history(true);
        watch.callback(heard).background().wait()?;
        let (graph, own, follow) = (Arc::clone(&self.graph), self.zid.clone(), self.follower());
        let refusals = Arc::clone(&self.refusals);
        let news = move |sample: Sample| {
            let key = sample.key_expr().as_str();
            let there = sample.kind() == SampleKind::Put;
            match End::parse(key) {
                Some(end) if end.node.session == own => {}
                Some(end) if !there => graph.lost(&end.id()),
                Some(end) => match graph.found(end, keys::gid(key)) {
                    Ok(name) => follow(name),
                    Err(why) => refusals.add(why, key),
                },
                None if there && !keys::is_of_node(key) => refusals.add(Reason::Token, key),
                None => {}
            }
        };
        let watch = liveliness.declare_subscriber(keys::all_tokens(self.domain)).history(true);
        watch.callback(news).background().wait()
    }

    /// Has the in ports of a topic look for the keys of its writers.
    fn follower(&self) -> impl Fn(Option<String>) + Send + Sync + use<> {
        let (readers, orders) = (Arc::clone(&self.readers), self.orders.clone());
        let graph = Arc::clone(&self.graph);
        move |name| {
            for reader in name.into_iter().flat_map(|name| readers.of(&name)) {
                // However many tokens arrive, one job at a time waits.
                if reader.is_to_follow() {
                    let graph = Arc::clone(&graph);
                    orders.submit(move |outgoing, _| reader.follow(&outgoing.session, &graph));
                }
            }
        }
    }

    /// Looks for a router when the router is gone.
    fn watch_router(&self, router: &Arc<Router>) -> zenoh::Result<()> {
        let (orders, router) = (self.orders.clone(), Arc::clone(router));
        let info = self.session.info();
        let events = info.transport_events_listener().callback(move |event| {
            if event.kind() == SampleKind::Delete
                && event.transport().whatami() == zenoh::config::WhatAmI::Router
            {
                router.seek();
                orders.ring();
            }
        });
        events.background().wait()
    }

    fn number(&self) -> u64 {
        self.next.fetch_add(1, Ordering::Relaxed)
    }

    /// The node of that name, with its namespace in front; shows it unless it is shown already.
    fn node(&self, name: &str) -> zenoh::Result<Arc<NodeShown>> {
        let mut nodes = lock(&self.nodes);
        if let Some(there) = nodes.get(name).and_then(Weak::upgrade) {
            return Ok(there);
        }
        nodes.retain(|_, node| node.strong_count() > 0);
        let (namespace, own) = names::split(name);
        let node = Node {
            session: self.zid.clone(),
            number: self.number(),
            namespace: format!("/{namespace}"),
            name: own.to_owned(),
        };
        let token = self.session.liveliness().declare_token(node.token(self.domain)).wait()?;
        let shown = Arc::new(NodeShown { node, _token: token });
        nodes.insert(name.to_owned(), Arc::downgrade(&shown));
        Ok(shown)
    }

    pub(crate) fn node_names(&self) -> HashSet<String> {
        let nodes = lock(&self.nodes);
        let shown = nodes.iter().filter(|(_, node)| node.strong_count() > 0);
        shown.map(|(name, _)| name.clone()).collect()
    }

    /// A number for a service that is told of before it exists.
    pub(crate) fn claim(&self, name: &str) -> u64 {
        let number = self.number();
        lock(&self.claimed).insert(name.to_owned(), number);
        number
    }

    /// Undoes [`claim`](Core::claim).
    pub(crate) fn unclaim(&self, name: &str) {
        lock(&self.claimed).remove(name);
    }

    /// An end of a node that is not shown yet.
    pub(crate) fn draft(
        &self,
        node: &str,
        kind: Kind,
        of: &Named,
        quality: Quality,
    ) -> Result<Draft, EndError> {
        let node = self.node(node)?;
        let claimed = (kind == Kind::Server).then(|| lock(&self.claimed).get(&of.name).copied());
        let number = claimed.flatten().unwrap_or_else(|| self.number());
        let hash = of.hash.clone().ok_or_else(|| EndError::NoHash(of.ty.clone()))?;
        let (name, ty) = (of.name.clone(), of.ty.to_dds(""));
        let shown = node.node.clone();
        let end = End { node: shown, number, kind, name, ty, hash, quality, buffers: false };
        Ok(Draft::of(end, node, self.domain))
    }

    pub(crate) fn show(&self, draft: &Draft) -> zenoh::Result<Shown> {
        let token = self.session.liveliness().declare_token(draft.token.clone()).wait()?;
        Ok(Shown { _token: token, _node: Arc::clone(&draft.node) })
    }

    /// Tells other daemons of an end.
    pub(crate) fn tell(&self, id: &Id, told: &Told) -> zenoh::Result<LivelinessToken> {
        self.session.liveliness().declare_token(told.token(self.domain, id)).wait()
    }
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
