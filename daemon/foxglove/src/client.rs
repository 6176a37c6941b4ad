//! One client: what it asked for, and what it is sent.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use foxglove::ws_protocol::BinaryMessage as _;
use foxglove::ws_protocol::client::Subscription;
use foxglove::ws_protocol::server::{MessageData, Status};
use genom_doors::RpcError;
use genom_protocol::Right;
use serde_json::Value;
use tokio::sync::Semaphore;
use tokio_tungstenite::tungstenite::Message;

use crate::advertised::ClientChannels;
use crate::inside::Asker;
use crate::lock::lock;
use crate::outbox::Outbox;
use crate::reply;

/// Calls of services and requests for parameters under way.
pub(crate) const CALLS: usize = 32;

/// A client.
#[derive(Debug)]
pub(crate) struct Client {
    pub(crate) outbox: Outbox,
    asker: Mutex<Asker>,
    /// Subscriptions by channel.
    subscriptions: Mutex<HashMap<u64, u32>>,
    /// Whether it wants the graph, and was told none yet.
    graph: AtomicBool,
    new_to_graph: AtomicBool,
    /// The parameters that it watches, as it knows them.
    pub(crate) parameters: Mutex<BTreeMap<String, Option<Value>>>,
    /// The channels on which it publishes.
    pub(crate) channels: ClientChannels,
    pub(crate) calls: Arc<Semaphore>,
}

/// Why a client cannot subscribe to a channel.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum SubscribeError {
    #[error("there is no channel {0}")]
    Channel(u64),
    #[error("there is a subscription {0} already")]
    Number(u32),
    #[error("channel {0} is subscribed to already")]
    Twice(u64),
}

impl Client {
    /// One that has asked for nothing yet; `backlog` bytes of samples may wait for it.
    pub(crate) fn new(asker: Asker, backlog: usize, channels: ClientChannels) -> Self {
        Self {
            outbox: Outbox::new(backlog),
            asker: Mutex::new(asker),
            subscriptions: Mutex::default(),
            graph: AtomicBool::new(false),
            new_to_graph: AtomicBool::new(false),
            parameters: Mutex::default(),
            channels,
            calls: Arc::new(Semaphore::new(CALLS)),
        }
    }

    /// In whose name its requests are made, with the rights that it has now.
    pub(crate) fn asker(&self) -> Asker {
        lock(&self.asker).clone()
    }

    /// It has these rights from now on.
    pub(crate) fn set_rights(&self, now: Vec<Right>) {
        lock(&self.asker).holder.rights = now;
    }

    /// Whether it has a right; the error names `what` needs it.
    pub(crate) fn may(&self, right: Right, what: &str) -> Result<(), RpcError> {
        self.asker().holder.may(right, what)
    }

    /// Subscribes it to a channel that there is.
    pub(crate) fn subscribe(&self, one: &Subscription) -> Result<(), SubscribeError> {
        let mut all = lock(&self.subscriptions);
        if all.values().any(|id| *id == one.id) {
            return Err(SubscribeError::Number(one.id));
        }
        if all.contains_key(&one.channel_id) {
            return Err(SubscribeError::Twice(one.channel_id));
        }
        all.insert(one.channel_id, one.id);
        Ok(())
    }

    /// Ends subscriptions.
    pub(crate) fn unsubscribe(&self, gone: &BTreeSet<u32>) {
        lock(&self.subscriptions).retain(|_, id| !gone.contains(id));
    }

    /// Whether it wants the graph, from now on.
    pub(crate) fn show_graph(&self, wanted: bool) {
        if wanted {
            self.new_to_graph.store(true, Ordering::Relaxed);
        }
        self.graph.store(wanted, Ordering::Relaxed);
    }

    /// The channels that it subscribed to.
    pub(crate) fn subscribed(&self) -> Vec<u64> {
        lock(&self.subscriptions).keys().copied().collect()
    }

    /// These channels are no more.
    pub(crate) fn forget(&self, gone: &BTreeSet<u64>) {
        lock(&self.subscriptions).retain(|channel, _| !gone.contains(channel));
    }

    /// Whether it wants the graph.
    pub(crate) fn sees_graph(&self) -> bool {
        self.graph.load(Ordering::Relaxed)
    }

    /// Whether it was told none of the graph yet; from now on it was.
    pub(crate) fn is_new_to_graph(&self) -> bool {
        self.new_to_graph.swap(false, Ordering::Relaxed)
    }

    /// Sends it a sample, if it subscribed to the channel.
    pub(crate) fn sample(&self, channel: u64, date: u64, message: &[u8]) {
        let Some(id) = lock(&self.subscriptions).get(&channel).copied() else { return };
        let data = MessageData::new(id, date, message);
        self.outbox.sample(Message::Binary(data.to_bytes().into()));
    }

    /// Tells it how many samples of a channel were lost, if it subscribed to it.
    pub(crate) fn lost(&self, channel: u64, topic: &str, count: u64) {
        if lock(&self.subscriptions).contains_key(&channel) {
            let told = format!("{count} samples of {topic} were lost: there were too many");
            let status = Status::warning(told).with_id(format!("lost {topic}"));
            self.outbox.say(reply::json(&status));
        }
    }
}
