//! What all clients share, and are told: the channels and services there are, the graph, samples.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use std::time::{SystemTime, UNIX_EPOCH};

use foxglove::ws_protocol::server::ServerInfo;
use foxglove::ws_protocol::server::server_info::Capability;
use genom_doors::Holder;
use genom_protocol::{ClockKind, Description, Right, Service, routes};
use tokio::sync::{Notify, Semaphore};
use tokio_tungstenite::tungstenite::Message;

use crate::catalogue::{Catalogue, Difference, Offered, no_more, no_more_services};
use crate::client::Client;
use crate::graph::Graph;
use crate::inside::{Asker, Inside};
use crate::lock::lock;
use crate::reply;

/// Calls of services under way, of all clients together.
const CALLS: usize = 128;

/// What all clients share.
#[derive(Debug)]
pub(crate) struct Hub {
    pub(crate) inside: Inside,
    /// In whose name is looked at what all clients may read.
    pub(crate) own: Asker,
    name: String,
    /// Distinguishes this run of the daemon from others.
    session: String,
    pub(crate) calls: Arc<Semaphore>,
    state: Mutex<State>,
    /// Held while it is looked at what there is: what is seen later is told later.
    looking: tokio::sync::Mutex<Seen>,
    /// Clients came or went, or subscribed to something.
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    clients: Vec<Arc<Client>>,
    catalogue: Catalogue,
    graph: Graph,
    clock: ClockKind,
}

/// Descriptions of services that were read already.
#[derive(Debug, Default)]
struct Seen {
    /// By component: digest of its interface, and its services.
    components: BTreeMap<String, (String, Vec<Arc<Service>>)>,
    /// Those that all components have, by name.
    standard: BTreeMap<String, Arc<Service>>,
}

impl Hub {
    pub(crate) fn new(inside: Inside, name: Option<&str>) -> Arc<Self> {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let holder = Holder::of("foxglove".to_owned(), vec![Right::Read]);
        Arc::new(Self {
            inside,
            own: Asker { holder, peer: None },
            name: name.map_or_else(|| "genomd".to_owned(), |name| format!("genomd {name}")),
            session: since.as_millis().to_string(),
            calls: Arc::new(Semaphore::new(CALLS)),
            state: Mutex::default(),
            looking: tokio::sync::Mutex::default(),
            changed: Notify::new(),
        })
    }

    /// Waits until clients come or go, or subscribe to something.
    pub(crate) async fn changed(&self) {
        self.changed.notified().await;
    }

    /// The topics that clients subscribed to; `None` if there are no clients.
    pub(crate) fn wanted(&self) -> Option<BTreeSet<String>> {
        let state = lock(&self.state);
        if state.clients.is_empty() {
            return None;
        }
        let wanted = state.clients.iter().flat_map(|client| client.subscribed());
        Some(wanted.filter_map(|id| state.catalogue.topic(id).map(str::to_owned)).collect())
    }

    /// Whether the clock of the daemon is virtual.
    pub(crate) fn is_virtual(&self) -> bool {
        lock(&self.state).clock.is_stepped()
    }

    /// Looks at the channels there are, and at the services too if `services`; tells clients what
    /// changed.
    pub(crate) async fn look(&self, services: bool) {
        let mut seen = self.looking.lock().await;
        match self.inside.ask(&self.own, &routes::channels(), "").await {
            Ok(now) => {
                let mut state = lock(&self.state);
                let Difference { new, gone } = state.catalogue.set_channels(now.channels);
                if !new.is_empty() || !gone.is_empty() {
                    let told: Vec<_> = no_more(&gone).into_iter().collect();
                    let told = [told, state.catalogue.announce(Some(&new))].concat();
                    for client in &state.clients {
                        client.forget(&gone);
                        told.iter().cloned().for_each(|message| client.outbox.say(message));
                    }
                }
            }
            Err(error) => tracing::debug!("foxglove: channels are not known: {error}"),
        }
        if services {
            let now = self.services(&mut seen).await;
            let mut state = lock(&self.state);
            let Difference { new, gone } = state.catalogue.set_services(now);
            let (catalogue, clients) = (&state.catalogue, &state.clients);
            for client in clients {
                no_more_services(&gone).into_iter().for_each(|message| client.outbox.say(message));
                let told = catalogue.announce_services(Some(&new), &client.asker().holder);
                told.into_iter().for_each(|message| client.outbox.say(message));
            }
        }
    }

    /// The services of all components that run.
    async fn services(&self, seen: &mut Seen) -> Vec<Offered> {
        let Ok(all) = self.inside.ask(&self.own, &routes::components(), "").await else {
            return lock(&self.state).catalogue.offered().cloned().collect();
        };
        let names: BTreeSet<_> = all.components.into_iter().map(|one| one.name).collect();
        seen.components.retain(|name, _| names.contains(name));
        for name in names {
            let described = self.inside.ask(&self.own, &routes::component(&name), "").await;
            match described {
                Ok(described) => self.describe(seen, &name, described).await,
                // It was unloaded meanwhile, or does not answer.
                Err(_) => _ = seen.components.remove(&name),
            }
        }
        let all = seen.components.iter().flat_map(|(name, (_, services))| {
            let offered = |service: &Arc<Service>| Offered {
                component: name.clone(),
                service: Arc::clone(service),
            };
            services.iter().map(offered).collect::<Vec<_>>()
        });
        all.collect()
    }

    /// Reads the schemas of a component's services, unless its interface is known.
    async fn describe(&self, seen: &mut Seen, name: &str, described: Description) {
        if seen.components.get(name).is_some_and(|(digest, _)| *digest == described.digest) {
            return;
        }
        let mut services = Vec::new();
        for service in described.services {
            if let Some(known) = seen.standard.get(&service.name).filter(|_| service.standard) {
                services.push(Arc::clone(known));
                continue;
            }
            let route = routes::service(name, &service.name);
            let Ok(whole) = self.inside.ask(&self.own, &route, "").await else { return };
            let whole = Arc::new(whole);
            if whole.standard {
                seen.standard.insert(whole.name.clone(), Arc::clone(&whole));
            }
            services.push(whole);
        }
        seen.components.insert(name.to_owned(), (described.digest, services));
    }

    /// Tells all clients something.
    pub(crate) fn tell(&self, message: &Message) {
        lock(&self.state).clients.iter().for_each(|client| client.outbox.say(message.clone()));
    }

    /// Whether a client subscribed to the graph.
    pub(crate) fn shows_graph(&self) -> bool {
        lock(&self.state).clients.iter().any(|client| client.sees_graph())
    }

    /// Tells who subscribed to the graph how it changed.
    pub(crate) fn draw(&self, now: Graph) {
        let mut state = lock(&self.state);
        let services = state.catalogue.offered().map(|one| (&one.component, &one.service.name));
        let now = now.with_services(services);
        for client in state.clients.iter().filter(|client| client.sees_graph()) {
            // Whoever just subscribed is told all of it.
            let known =
                if client.is_new_to_graph() { Graph::default() } else { state.graph.clone() };
            if let Some(change) = now.since(&known) {
                client.outbox.say(change);
            }
        }
        state.graph = now;
    }

    /// What this source can do for a client.
    fn greeting(&self, client: &Client, clock: ClockKind) -> Message {
        let mut able = vec![Capability::ConnectionGraph];
        if client.may(Right::Call, "").is_ok() {
            able.extend([
                Capability::ClientPublish,
                Capability::Services,
                Capability::Parameters,
                Capability::ParametersSubscribe,
            ]);
        }
        if clock.is_stepped() {
            able.push(Capability::Time);
        }
        let info = ServerInfo::new(self.name.clone())
            .with_capabilities(able)
            .with_supported_encodings(["json", "cdr"])
            .with_session_id(self.session.clone());
        reply::json(&info)
    }

    /// Adds a client, and tells it what there is.
    pub(crate) async fn join(&self, client: &Arc<Client>) {
        let first = lock(&self.state).clients.is_empty();
        if let Ok(clock) = self.inside.ask(&self.own, &routes::clock(), "").await {
            lock(&self.state).clock = clock.clock;
        }
        // While nobody is there, nobody looks.
        self.look(first).await;
        let mut state = lock(&self.state);
        client.outbox.say(self.greeting(client, state.clock));
        state.catalogue.announce(None).into_iter().for_each(|message| client.outbox.say(message));
        let services = state.catalogue.announce_services(None, &client.asker().holder);
        services.into_iter().for_each(|message| client.outbox.say(message));
        state.clients.push(Arc::clone(client));
        drop(state);
        self.changed.notify_one();
    }

    /// Removes a client.
    pub(crate) fn leave(&self, client: &Arc<Client>) {
        lock(&self.state).clients.retain(|other| !Arc::ptr_eq(other, client));
        self.changed.notify_one();
    }

    /// A client subscribed to something else.
    pub(crate) fn subscriptions_changed(&self) {
        self.changed.notify_one();
    }

    /// Whether there is such a channel.
    pub(crate) fn has_channel(&self, id: u64) -> bool {
        lock(&self.state).catalogue.topic(id).is_some()
    }

    /// A service by its number.
    pub(crate) fn service(&self, id: u32) -> Option<Offered> {
        lock(&self.state).catalogue.service(id).cloned()
    }

    /// All services that `wanted` takes.
    pub(crate) fn offered(&self, wanted: impl Fn(&Offered) -> bool) -> Vec<Offered> {
        lock(&self.state).catalogue.offered().filter(|one| wanted(one)).cloned().collect()
    }

    /// Passes a sample to the clients that subscribed to its topic.
    pub(crate) fn deliver(&self, topic: &str, date: u64, message: &[u8]) {
        let state = lock(&self.state);
        if let Some(channel) = state.catalogue.channel(topic) {
            state.clients.iter().for_each(|client| client.sample(channel, date, message));
        }
    }

    /// Tells the clients of a topic how many of its samples were lost before they came here.
    pub(crate) fn lost(&self, topic: &str, count: u64) {
        let state = lock(&self.state);
        if let Some(channel) = state.catalogue.channel(topic) {
            state.clients.iter().for_each(|client| client.lost(channel, topic, count));
        }
    }
}
