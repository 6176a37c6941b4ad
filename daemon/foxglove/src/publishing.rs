//! Values that a client publishes to in ports.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use foxglove::ws_protocol::client::advertise::Channel;
use foxglove::ws_protocol::server::{RemoveStatus, Status};
use genom_protocol::{Address, ValueParameters, routes};
use tokio::sync::mpsc;

use crate::client::{Client, lock};
use crate::hub::Hub;
use crate::reply;

/// Channels that a client may have.
const MOST: usize = 256;
/// Values that may wait to be published.
const WAITING: usize = 64;

/// The channels of one client.
#[derive(Debug)]
pub(crate) struct Publishing {
    channels: Mutex<HashMap<u32, Address>>,
    values: mpsc::Sender<Value>,
}

/// A value for an in port, as JSON.
#[derive(Debug)]
pub(crate) struct Value {
    to: Address,
    json: Vec<u8>,
}

impl Publishing {
    pub(crate) fn new() -> (Self, mpsc::Receiver<Value>) {
        let (values, waiting) = mpsc::channel(WAITING);
        (Self { channels: Mutex::default(), values }, waiting)
    }

    /// Takes a channel.
    pub(crate) fn advertise(&self, channel: &Channel<'_>) -> Result<(), String> {
        let topic: String = channel.topic.chars().take(200).collect();
        let topic = topic.escape_default();
        if channel.encoding != "json" {
            let encoding: String = channel.encoding.chars().take(50).collect();
            let encoding = encoding.escape_default();
            return Err(format!("{topic}: values are published as `json`, not `{encoding}`"));
        }
        let address = channel.topic.strip_prefix('/').and_then(|name| name.parse().ok());
        let Some(address) = address else {
            return Err(format!("{topic}: the topic of an in port is /COMPONENT/PORT"));
        };
        let mut channels = lock(&self.channels);
        if channels.len() >= MOST && !channels.contains_key(&channel.id) {
            return Err(format!("{topic}: {MOST} channels of a client, no more"));
        }
        channels.insert(channel.id, address);
        Ok(())
    }

    pub(crate) fn unadvertise(&self, gone: &[u32]) {
        let mut channels = lock(&self.channels);
        gone.iter().for_each(|id| drop(channels.remove(id)));
    }

    /// Takes a value, which is published soon.
    pub(crate) fn take(&self, channel: u32, json: &[u8]) -> Result<(), String> {
        let Some(to) = lock(&self.channels).get(&channel).cloned() else {
            return Err(format!("there is no channel {channel} of this client"));
        };
        let value = Value { json: json.to_vec(), to };
        self.values.try_send(value).map_err(|refused| {
            let topic = &refused.into_inner().to;
            format!("/{topic}: a value was left out, since {WAITING} others wait")
        })
    }
}

/// Publishes values one after the other, until the client is gone.
pub(crate) async fn publish(hub: &Hub, client: &Arc<Client>, mut values: mpsc::Receiver<Value>) {
    // What was told last of each topic.
    let mut told: HashMap<Address, String> = HashMap::new();
    while let Some(Value { to, json }) = values.recv().await {
        let query = ValueParameters { element: to.element.clone() };
        let route = routes::publish(&to.component, &to.port).with(&query);
        let id = format!("publish /{to}");
        match hub.inside.ask(&client.asker(), &route, json).await {
            Ok(_) => {
                if told.remove(&to).is_some() {
                    client.outbox.say(reply::json(&RemoveStatus { status_ids: vec![id] }));
                }
            }
            Err(error) => {
                let message = format!("/{to}: {error}");
                if told.len() >= MOST {
                    told.clear();
                }
                if told.get(&to) != Some(&message) {
                    let status = Status::error(message.clone()).with_id(id);
                    client.outbox.say(reply::json(&status));
                    told.insert(to, message);
                }
            }
        }
    }
}
