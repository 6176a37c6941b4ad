//! The channels on which a client publishes, and the values that wait to be published.

use std::collections::HashMap;
use std::sync::Mutex;

use foxglove::ws_protocol::client::advertise::Channel;
use genom_protocol::Address;
use tokio::sync::mpsc;

use crate::lock::lock;

/// Channels that a client may have.
pub(crate) const MOST: usize = 256;
/// Values that may wait to be published.
const WAITING: usize = 64;

/// The channels of one client.
#[derive(Debug)]
pub(crate) struct ClientChannels {
    channels: Mutex<HashMap<u32, Address>>,
    values: mpsc::Sender<Value>,
}

/// A value for an in port, as JSON.
#[derive(Debug)]
pub(crate) struct Value {
    pub(crate) to: Address,
    pub(crate) json: Vec<u8>,
}

/// Why a client cannot publish on a channel.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum AdvertiseError {
    #[error("{topic}: values are published as `json`, not `{encoding}`")]
    Encoding { topic: String, encoding: String },
    #[error("{0}: the topic of an in port is /COMPONENT/PORT")]
    Topic(String),
    #[error("{0}: {MOST} channels of a client, no more")]
    TooMany(String),
}

/// Why a value is not published.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum ValueError {
    #[error("there is no channel {0} of this client")]
    Channel(u32),
    #[error("/{0}: a value was left out, since {WAITING} others wait")]
    TooMany(Address),
}

impl ClientChannels {
    pub(crate) fn new() -> (Self, mpsc::Receiver<Value>) {
        let (values, waiting) = mpsc::channel(WAITING);
        (Self { channels: Mutex::default(), values }, waiting)
    }

    /// Takes a channel.
    pub(crate) fn advertise(&self, channel: &Channel<'_>) -> Result<(), AdvertiseError> {
        let topic: String = channel.topic.chars().take(200).collect();
        let topic = topic.escape_default().to_string();
        if channel.encoding != "json" {
            let encoding: String = channel.encoding.chars().take(50).collect();
            let encoding = encoding.escape_default().to_string();
            return Err(AdvertiseError::Encoding { topic, encoding });
        }
        let address = channel.topic.strip_prefix('/').and_then(|name| name.parse().ok());
        let Some(address) = address else {
            return Err(AdvertiseError::Topic(topic));
        };
        let mut channels = lock(&self.channels);
        if channels.len() >= MOST && !channels.contains_key(&channel.id) {
            return Err(AdvertiseError::TooMany(topic));
        }
        channels.insert(channel.id, address);
        Ok(())
    }

    pub(crate) fn unadvertise(&self, gone: &[u32]) {
        let mut channels = lock(&self.channels);
        gone.iter().for_each(|id| drop(channels.remove(id)));
    }

    /// Takes a value, which is published soon.
    pub(crate) fn take(&self, channel: u32, json: &[u8]) -> Result<(), ValueError> {
        let Some(to) = lock(&self.channels).get(&channel).cloned() else {
            return Err(ValueError::Channel(channel));
        };
        let value = Value { json: json.to_vec(), to };
        let sent = self.values.try_send(value);
        sent.map_err(|refused| ValueError::TooMany(refused.into_inner().to))
    }
}
