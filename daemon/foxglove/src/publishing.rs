//! Publishes to in ports what a client sends.

use std::collections::HashMap;

use foxglove::ws_protocol::server::{RemoveStatus, Status};
use genom_protocol::{Address, ValueParameters, routes};
use tokio::sync::mpsc;

use crate::advertised::{MOST, Value};
use crate::client::Client;
use crate::inside::Inside;
use crate::reply;

/// Publishes values one after the other, until the client is gone.
pub(crate) async fn publish(inside: &Inside, client: &Client, mut values: mpsc::Receiver<Value>) {
    // What was told last of each topic.
    let mut told: HashMap<Address, String> = HashMap::new();
    while let Some(Value { to, json }) = values.recv().await {
        let query = ValueParameters { element: to.element.clone() };
        let route = routes::publish(&to.component, &to.port).with(&query);
        let id = format!("publish /{to}");
        match inside.ask(&client.asker(), &route, json).await {
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
