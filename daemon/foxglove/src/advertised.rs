//! The channels on which a client publishes, and the values that wait to be published.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use foxglove::ws_protocol::client::advertise::Channel;
use genom_protocol::{Address, MessageType};
use genom_recording::same_type;
use tokio::sync::mpsc;

use crate::lock::lock;

/// Channels that a client may have.
pub(crate) const MOST: usize = 256;
/// Values that may wait to be published.
const WAITING: usize = 64;

/// The channels of one client.
#[derive(Debug)]
pub(crate) struct ClientChannels {
    channels: Mutex<HashMap<u32, (Address, Form)>>,
    values: mpsc::Sender<Value>,
}

/// How the values of a channel are written.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    /// JSON; members that are left out keep their values.
    Json,
    /// CDR with its encapsulation header, of the type that the client names.
    Cdr(Arc<Claim>),
}

/// The type that a client says its values have.
#[derive(Debug)]
pub(crate) struct Claim {
    /// `PACKAGE/msg/NAME`.
    name: String,
    /// As a definition of ROS 2 messages; clients may leave it out.
    definition: Option<String>,
}

/// A value for an in port.
#[derive(Debug)]
pub(crate) struct Value {
    pub(crate) to: Address,
    pub(crate) form: Form,
    pub(crate) data: Vec<u8>,
}

/// Why a client cannot publish on a channel.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum AdvertiseError {
    #[error("{topic}: values are published as `json` or `cdr`, not `{encoding}`")]
    Encoding { topic: String, encoding: String },
    #[error("{0}: values as `cdr` need the name of their type (`schemaName`)")]
    Nameless(String),
    #[error("{0}: the topic of an in port is /COMPONENT/PORT")]
    Topic(String),
    #[error("{0}: {MOST} channels of a client, no more")]
    TooMany(String),
}

impl Claim {
    /// Whether it is this type. Values of another type might be read as values of this one, and be
    /// wrong.
    pub(crate) fn is(&self, ty: &MessageType) -> bool {
        let defined = ty.definition.as_deref().unwrap_or_default();
        let same = |claimed: &String| same_type(claimed.as_bytes(), defined.as_bytes());
        self.name == ty.name && self.definition.as_ref().is_none_or(same)
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }
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
        let topic = cut(&channel.topic, 200);
        let form = match &*channel.encoding {
            "json" => Form::Json,
            "cdr" if channel.schema_name.is_empty() => {
                return Err(AdvertiseError::Nameless(topic));
            }
            "cdr" => Form::Cdr(Arc::new(claim(channel))),
            other => {
                return Err(AdvertiseError::Encoding { topic, encoding: cut(other, 50) });
            }
        };
        let address = channel.topic.strip_prefix('/').and_then(|name| name.parse().ok());
        let Some(address) = address else {
            return Err(AdvertiseError::Topic(topic));
        };
        let mut channels = lock(&self.channels);
        if channels.len() >= MOST && !channels.contains_key(&channel.id) {
            return Err(AdvertiseError::TooMany(topic));
        }
        channels.insert(channel.id, (address, form));
        Ok(())
    }

    pub(crate) fn unadvertise(&self, gone: &[u32]) {
        let mut channels = lock(&self.channels);
        gone.iter().for_each(|id| drop(channels.remove(id)));
    }

    /// Takes a value, which is published soon.
    pub(crate) fn take(&self, channel: u32, data: &[u8]) -> Result<(), ValueError> {
        let Some((to, form)) = lock(&self.channels).get(&channel).cloned() else {
            return Err(ValueError::Channel(channel));
        };
        let value = Value { data: data.to_vec(), form, to };
        let sent = self.values.try_send(value);
        sent.map_err(|refused| ValueError::TooMany(refused.into_inner().to))
    }
}

/// What a client says about the type of a channel. A definition in another language than that of
/// ROS 2 messages is not compared.
fn claim(channel: &Channel<'_>) -> Claim {
    let language = channel.schema_encoding.as_deref().unwrap_or("ros2msg");
    let definition = channel.schema.as_deref().filter(|text| !text.is_empty());
    Claim {
        name: cut(&channel.schema_name, 200),
        definition: definition.filter(|_| language == "ros2msg").map(str::to_owned),
    }
}

/// The beginning of a client's text, fit to be shown.
fn cut(text: &str, most: usize) -> String {
    let text: String = text.chars().take(most).collect();
    text.escape_default().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_is_the_same_by_its_name_and_by_its_definition_where_there_is_one() {
        let ty = |name: &str, definition: &str| MessageType {
            name: name.to_owned(),
            definition: Some(definition.to_owned()),
        };
        let claimed = |definition: &str, language: &str| {
            let channel = serde_json::json!({
                "id": 1, "topic": "/a/b", "encoding": "cdr", "schemaName": "demo/msg/State",
                "schema": definition, "schemaEncoding": language,
            });
            claim(&serde_json::from_str(&channel.to_string()).unwrap())
        };
        let now = ty("demo/msg/State", "float64 position\n");
        assert!(claimed("", "ros2msg").is(&now));
        assert!(claimed("float64 position # m", "ros2msg").is(&now));
        assert!(!claimed("float64 speed", "ros2msg").is(&now));
        assert!(claimed("struct State { double position; };", "omgidl").is(&now));
        assert!(!claimed("", "ros2msg").is(&ty("demo/msg/Status", "float64 position\n")));
    }
}
