//! One client: what it asks for, and what it is sent.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use foxglove::ws_protocol::BinaryMessage as _;
use foxglove::ws_protocol::client::{ClientMessage, Subscription};
use foxglove::ws_protocol::server::server_info::Capability;
use foxglove::ws_protocol::server::{MessageData, ServerInfo, Status};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use genom_doors::{Holder, Peer};
use genom_protocol::{ClockKind, Right};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use serde_json::Value;
use tokio::sync::Semaphore;
use tokio::time::{interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::{Bytes, Message};

use crate::gate::Visitor;
use crate::hub::Hub;
use crate::inside::Asker;
use crate::outbox::Outbox;
use crate::publishing::{self, Publishing};
use crate::server::Foxglove;
use crate::{calls, parameters, reply};

/// How often a client is asked for a sign of life, and how long it may give none.
const PING: Duration = Duration::from_secs(15);
const SILENCE: Duration = Duration::from_secs(60);
/// How often parameters that a client watches are read, and whether its token is still known.
const WATCH: Duration = Duration::from_millis(500);
/// Messages that are none of the protocol; a client that sends more is sent away.
const WRONG: usize = 16;
/// Calls of services and requests for parameters under way.
pub(crate) const CALLS: usize = 32;
/// How long the last words to a client may take.
const LAST: Duration = Duration::from_secs(2);

type Socket = WebSocketStream<TokioIo<Upgraded>>;

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
    pub(crate) publishing: Publishing,
    pub(crate) calls: Arc<Semaphore>,
}

pub(crate) fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Serves a client until one of both sides ends it.
pub(crate) async fn serve(
    foxglove: &Foxglove,
    hub: &Arc<Hub>,
    visitor: Visitor,
    peer: Option<Peer>,
    socket: Socket,
) {
    let Some(holder) = visitor.now(&foxglove.0.tokens) else { return };
    tracing::debug!("foxglove: {} came", holder.who);
    let (mut sink, stream) = socket.split();
    let (publishing, values) = Publishing::new();
    let client = Arc::new(Client {
        outbox: Outbox::new(foxglove.0.section.backlog),
        asker: Mutex::new(Asker { holder, peer }),
        subscriptions: Mutex::default(),
        graph: AtomicBool::new(false),
        new_to_graph: AtomicBool::new(false),
        parameters: Mutex::default(),
        publishing,
        calls: Arc::new(Semaphore::new(CALLS)),
    });
    let serving = async {
        hub.join(&client).await;
        read(hub, &client, stream).await
    };
    let why = tokio::select! {
        why = serving => why,
        why = write(&client, &mut sink) => why,
        () = publishing::publish(hub, &client, values) => "",
        () = watch(foxglove, hub, &client, &visitor) => "its token is not known any more",
        () = foxglove.0.closed.cancelled() => "the daemon stops",
    };
    hub.leave(&client);
    tracing::debug!("foxglove: {} left: {why}", client.asker().holder.who);
    let last = async {
        if !why.is_empty() {
            let _ = sink.send(reply::error(why)).await;
        }
        let _ = sink.close().await;
    };
    let _ = timeout(LAST, last).await;
}

/// Reads what the client sends; returns why it is sent away.
async fn read(hub: &Arc<Hub>, client: &Arc<Client>, mut from: SplitStream<Socket>) -> &'static str {
    let mut wrong = 0;
    loop {
        let message = match timeout(SILENCE, from.next()).await {
            Ok(Some(Ok(message @ (Message::Text(_) | Message::Binary(_))))) => message,
            Ok(Some(Ok(Message::Close(_))) | None) => return "",
            Ok(Some(Ok(_))) => continue,
            Ok(Some(Err(error))) => {
                tracing::debug!("foxglove: a client sent something unreadable: {error}");
                return "";
            }
            Err(_) => return "no sign of life",
        };
        let told = match ClientMessage::try_from(&message) {
            Ok(message) => client.obey(hub, message),
            Err(error) => {
                wrong += 1;
                if wrong > WRONG {
                    return "too many messages that are none of the protocol";
                }
                Err(format!("a message that is none of the protocol: {error}"))
            }
        };
        if let Err(told) = told {
            client.outbox.say(reply::error(told));
        }
    }
}

/// Sends what waits; returns why the client is sent away.
async fn write(client: &Client, to: &mut SplitSink<Socket, Message>) -> &'static str {
    let mut pings = interval(PING);
    pings.reset();
    let mut losses = interval(Duration::from_secs(1));
    loop {
        let message = tokio::select! {
            biased;
            _ = pings.tick() => Message::Ping(Bytes::new()),
            _ = losses.tick() => match client.outbox.newly_dropped() {
                Some(count) => {
                    let told = format!(
                        "{count} samples were left out so far: this client takes them too slowly"
                    );
                    reply::json(&Status::warning(told).with_id("dropped"))
                }
                None => continue,
            },
            next = client.outbox.next() => match next {
                Some(message) => message,
                None => return "it takes nothing of what it is sent",
            },
        };
        if to.send(message).await.is_err() {
            return "";
        }
    }
}

/// Keeps parameters up to date; returns when the client's token is gone.
async fn watch(foxglove: &Foxglove, hub: &Arc<Hub>, client: &Arc<Client>, visitor: &Visitor) {
    let mut ticks = interval(WATCH);
    loop {
        ticks.tick().await;
        let Some(now) = visitor.now(&foxglove.0.tokens) else { return };
        lock(&client.asker).holder.rights = now.rights;
        parameters::tell_changed(hub, client).await;
    }
}

/// Does all, and returns the first error of it.
fn first_error(all: impl Iterator<Item = Result<(), String>>) -> Result<(), String> {
    all.fold(Ok(()), Result::and)
}

impl Client {
    /// In whose name its requests are made, with the rights that it has now.
    pub(crate) fn asker(&self) -> Asker {
        lock(&self.asker).clone()
    }

    fn may(&self, right: Right, what: &str) -> Result<(), String> {
        let holder: Holder = self.asker().holder;
        holder.may(right, what).map_err(|error| error.message().to_owned())
    }

    /// Tells what this source can do for it.
    pub(crate) fn greet(&self, hub: &Hub, clock: ClockKind) {
        let mut able = vec![Capability::ConnectionGraph];
        if self.may(Right::Call, "").is_ok() {
            able.extend([
                Capability::ClientPublish,
                Capability::Services,
                Capability::Parameters,
                Capability::ParametersSubscribe,
            ]);
        }
        if clock == ClockKind::Virtual {
            able.push(Capability::Time);
        }
        let info = ServerInfo::new(hub.name.clone())
            .with_capabilities(able)
            .with_supported_encodings(["json"])
            .with_session_id(hub.session.clone());
        self.outbox.say(reply::json(&info));
    }

    /// Does what a message asks for; what takes time goes on beside.
    fn obey(self: &Arc<Self>, hub: &Arc<Hub>, message: ClientMessage<'_>) -> Result<(), String> {
        match message {
            ClientMessage::Subscribe(asked) => {
                let all = asked.subscriptions.into_iter();
                let told = first_error(all.map(|one| self.subscribe(hub, one)));
                hub.subscriptions_changed();
                told
            }
            ClientMessage::Unsubscribe(asked) => {
                let gone: BTreeSet<_> = asked.subscription_ids.into_iter().collect();
                lock(&self.subscriptions).retain(|_, id| !gone.contains(id));
                hub.subscriptions_changed();
                Ok(())
            }
            ClientMessage::Advertise(asked) => {
                self.may(Right::Call, "publishing")?;
                first_error(asked.channels.iter().map(|one| self.publishing.advertise(one)))
            }
            ClientMessage::Unadvertise(asked) => {
                self.publishing.unadvertise(&asked.channel_ids);
                Ok(())
            }
            ClientMessage::MessageData(sent) => self.publishing.take(sent.channel_id, &sent.data),
            ClientMessage::ServiceCallRequest(asked) => {
                calls::call(hub, self, &asked);
                Ok(())
            }
            ClientMessage::GetParameters(asked) => {
                self.may(Right::Call, "reading parameters")?;
                parameters::get(hub, self, asked)
            }
            ClientMessage::SetParameters(asked) => {
                self.may(Right::Call, "setting parameters")?;
                parameters::set(hub, self, asked)
            }
            ClientMessage::SubscribeParameterUpdates(asked) => {
                self.may(Right::Call, "reading parameters")?;
                parameters::subscribe(self, asked.parameter_names)
            }
            ClientMessage::UnsubscribeParameterUpdates(asked) => {
                let mut watched = lock(&self.parameters);
                asked.parameter_names.iter().for_each(|name| drop(watched.remove(name)));
                Ok(())
            }
            ClientMessage::SubscribeConnectionGraph => {
                self.new_to_graph.store(true, Ordering::Relaxed);
                self.graph.store(true, Ordering::Relaxed);
                hub.subscriptions_changed();
                Ok(())
            }
            ClientMessage::UnsubscribeConnectionGraph => {
                self.graph.store(false, Ordering::Relaxed);
                Ok(())
            }
            ClientMessage::FetchAsset(_) => Err("there are no assets here".to_owned()),
            ClientMessage::PlaybackControlRequest(_) => {
                Err("this is live, and cannot be played back".to_owned())
            }
        }
    }

    fn subscribe(&self, hub: &Hub, one: Subscription) -> Result<(), String> {
        if !hub.has_channel(one.channel_id) {
            return Err(format!("there is no channel {}", one.channel_id));
        }
        let mut all = lock(&self.subscriptions);
        if all.values().any(|id| *id == one.id) {
            return Err(format!("there is a subscription {} already", one.id));
        }
        if all.contains_key(&one.channel_id) {
            return Err(format!("channel {} is subscribed to already", one.channel_id));
        }
        all.insert(one.channel_id, one.id);
        Ok(())
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
