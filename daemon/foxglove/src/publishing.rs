//! Publishes to in ports what a client sends.

use std::collections::HashMap;

use foxglove::ws_protocol::server::{RemoveStatus, Status};
use genom_protocol::{Address, ValueParameters, replay, routes};
use tokio::sync::mpsc;

use crate::advertised::{Claim, Form, MOST, Value};
use crate::client::Client;
use crate::hub::Hub;
use crate::inside::Refused;
use crate::reply;

/// Publishes values one after the other, until the client is gone.
pub(crate) async fn publish(hub: &Hub, client: &Client, mut values: mpsc::Receiver<Value>) {
    // What was told last of each topic.
    let mut told: HashMap<Address, String> = HashMap::new();
    while let Some(Value { to, form, data }) = values.recv().await {
        let id = format!("publish /{to}");
        let published = match form {
            Form::Json => json(hub, client, &to, data).await,
            Form::Cdr(claim) => cdr(hub, client, &to, &claim, &data).await,
        };
        match published {
            Ok(()) => {
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

async fn json(hub: &Hub, client: &Client, to: &Address, value: Vec<u8>) -> Result<(), Refused> {
    let query = ValueParameters { element: to.element.clone() };
    let route = routes::publish(&to.component, &to.port).with(&query);
    hub.inside.ask(&client.asker(), &route, value).await.map(drop)
}

/// Publishes a message of CDR. The port's type is asked for each time: its component may have been
/// loaded again, with another one.
async fn cdr(
    hub: &Hub,
    client: &Client,
    to: &Address,
    claim: &Claim,
    message: &[u8],
) -> Result<(), Refused> {
    let route = routes::port_type(&to.component, &to.port);
    let ty = hub.inside.ask(&hub.own, &route, "").await?.message;
    if !claim.is(&ty) {
        let (sent, now) = (claim.name(), ty.name);
        let why = if sent == now { "is defined otherwise here" } else { "is not its type" };
        return Err(Refused(format!("{sent} {why}; the port has {now}")));
    }
    let mut samples = Vec::with_capacity(message.len() + 256);
    replay::append(&mut samples, &to.to_string(), message);
    hub.inside.ask(&client.asker(), &routes::replay(), samples).await.map(drop)
}
