//! A client from its first message to its last one.

use std::sync::Arc;
use std::time::Duration;

use foxglove::ws_protocol::client::ClientMessage;
use foxglove::ws_protocol::server::Status;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use genom_doors::Peer;
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::time::{interval, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::{Bytes, Message};

use crate::advertised::ClientChannels;
use crate::client::Client;
use crate::gate::Visitor;
use crate::hub::Hub;
use crate::inside::Asker;
use crate::terms::Terms;
use crate::{orders, parameters, publishing, reply};

/// How often a client is asked for a sign of life, and how long it may give none.
const PING: Duration = Duration::from_secs(15);
const SILENCE: Duration = Duration::from_secs(60);
/// How often parameters that a client watches are read, and whether its token is still known.
const WATCH: Duration = Duration::from_millis(500);
/// Messages that are none of the protocol; a client that sends more is sent away.
const WRONG: usize = 16;
/// How long the last words to a client may take.
const LAST: Duration = Duration::from_secs(2);

type Socket = WebSocketStream<TokioIo<Upgraded>>;

/// Serves a client until one of both sides ends it.
pub(crate) async fn serve(
    terms: &Terms,
    hub: &Arc<Hub>,
    visitor: Visitor,
    peer: Option<Peer>,
    socket: Socket,
) {
    let Some(holder) = visitor.now(&terms.tokens) else { return };
    tracing::debug!("foxglove: {} came", holder.who);
    let (mut sink, stream) = socket.split();
    let (channels, values) = ClientChannels::new();
    let client = Client::new(Asker { holder, peer }, terms.section.backlog, channels);
    let client = Arc::new(client);
    let serving = async {
        hub.join(&client).await;
        read(hub, &client, stream).await
    };
    let why = tokio::select! {
        why = serving => why,
        why = write(&client, &mut sink) => why,
        () = publishing::publish(hub, &client, values) => "",
        () = watch(terms, hub, &client, &visitor) => "its token is not known any more",
        () = terms.closed.cancelled() => "the daemon stops",
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
            Ok(message) => orders::obey(hub, client, message).map_err(|error| error.to_string()),
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
async fn watch(terms: &Terms, hub: &Arc<Hub>, client: &Arc<Client>, visitor: &Visitor) {
    let mut ticks = interval(WATCH);
    loop {
        ticks.tick().await;
        let Some(now) = visitor.now(&terms.tokens) else { return };
        client.set_rights(now.rights);
        parameters::tell_changed(hub, client).await;
    }
}
