//! Parameters: the inputs of attributes, named `/COMPONENT/ATTRIBUTE/INPUT`.
//!
//! They are read and set as every client of the control plane does it: the value is that which the
//! attribute keeps if the input is left out, and setting it calls the attribute. Both take the right
//! `call`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use foxglove::ws_protocol::client::{GetParameters, SetParameters};
use foxglove::ws_protocol::parameter::{Parameter, ParameterType, ParameterValue};
use foxglove::ws_protocol::server::ParameterValues;
use genom_protocol::{ServiceKind, routes};
use serde_json::{Map, Value};
use tokio_tungstenite::tungstenite::Message;

use crate::catalogue::Offered;
use crate::client::{CALLS, Client};
use crate::hub::Hub;
use crate::inside::Refused;
use crate::lock::lock;
use crate::{calls, reply};

/// Names in one message, and that a client may watch.
const MOST: usize = 1024;

/// Why parameters are not read, set or watched.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum ParametersError {
    #[error("{0} parameters, {MOST} at most")]
    TooMany(usize),
    #[error("an id of {0} bytes, {MOST} at most")]
    LongId(usize),
    #[error("{CALLS} requests are under way already: wait for one to be answered")]
    Busy,
}

fn is_parameter(offered: &Offered) -> bool {
    offered.service.kind == ServiceKind::Attribute && !offered.service.standard
}

fn too_many(count: usize) -> Result<(), ParametersError> {
    if count > MOST { Err(ParametersError::TooMany(count)) } else { Ok(()) }
}

/// The answer has it, too.
fn too_long(id: Option<&String>) -> Result<(), ParametersError> {
    match id {
        Some(id) if id.len() > MOST => Err(ParametersError::LongId(id.len())),
        _ => Ok(()),
    }
}

/// `/COMPONENT/ATTRIBUTE/INPUT`, split.
fn split(name: &str) -> Option<(&str, &str, &str)> {
    let mut parts = name.strip_prefix('/')?.split('/');
    let found = (parts.next()?, parts.next()?, parts.next()?);
    parts.next().is_none().then_some(found)
}

/// Sends the parameters of these names, or all.
pub(crate) fn get(
    hub: &Arc<Hub>,
    client: &Arc<Client>,
    asked: GetParameters,
) -> Result<(), ParametersError> {
    too_many(asked.parameter_names.len())?;
    too_long(asked.id.as_ref())?;
    beside(hub, client, |hub, client| async move {
        let names: BTreeSet<_> = asked.parameter_names.into_iter().collect();
        let values = read(&hub, &client, (!names.is_empty()).then_some(&names)).await;
        client.outbox.say(told(values, asked.id));
    })
}

/// Sets parameters, and sends what they are then.
pub(crate) fn set(
    hub: &Arc<Hub>,
    client: &Arc<Client>,
    asked: SetParameters,
) -> Result<(), ParametersError> {
    too_many(asked.parameters.len())?;
    too_long(asked.id.as_ref())?;
    beside(hub, client, |hub, client| async move {
        let mut names = BTreeSet::new();
        for parameter in asked.parameters {
            if let Err(why) = set_one(&hub, &client, &parameter).await {
                let name: String = parameter.name.chars().take(200).collect();
                let message = format!("{} was not set: {why}", name.escape_default());
                client.outbox.say(reply::error(message));
            }
            names.insert(parameter.name);
        }
        let values = read(&hub, &client, Some(&names)).await;
        client.outbox.say(told(values, asked.id));
    })
}

async fn set_one(hub: &Hub, client: &Client, parameter: &Parameter) -> Result<(), Refused> {
    let refused = |why: &str| Refused(why.to_owned());
    let name = split(&parameter.name);
    let (component, service, input) =
        name.ok_or_else(|| refused("a name is /COMPONENT/ATTRIBUTE/INPUT"))?;
    let known = hub.offered(|one| {
        is_parameter(one) && one.component == component && one.service.name == service
    });
    if known.is_empty() {
        return Err(refused("there is no such attribute"));
    }
    let value = parameter.value.as_ref().ok_or_else(|| refused("it cannot be removed"))?;
    let value = serde_json::to_value(value).map_err(|error| Refused(error.to_string()))?;
    let inputs = Value::Object(Map::from_iter([(input.to_owned(), value)])).to_string();
    let by = client.asker();
    calls::ask(&hub.inside, &by, component, service, inputs.into_bytes()).await.map(drop)
}

/// Watches these parameters from now on.
pub(crate) fn subscribe(client: &Client, names: Vec<String>) -> Result<(), ParametersError> {
    let mut watched = lock(&client.parameters);
    let new = names.iter().filter(|name| !watched.contains_key(*name)).count();
    too_many(watched.len() + new)?;
    for name in names {
        watched.entry(name).or_default();
    }
    Ok(())
}

/// Sends the parameters that a client watches and that changed.
pub(crate) async fn tell_changed(hub: &Hub, client: &Client) {
    let names: BTreeSet<_> = lock(&client.parameters).keys().cloned().collect();
    if names.is_empty() {
        return;
    }
    let mut now = read(hub, client, Some(&names)).await;
    let mut watched = lock(&client.parameters);
    now.retain(|name, value| match watched.get_mut(name) {
        Some(known) if known.as_ref() != Some(value) => {
            *known = Some(value.clone());
            true
        }
        _ => false,
    });
    if !now.is_empty() {
        client.outbox.say(told(now, None));
    }
}

/// The values of these parameters, or of all; those that cannot be read are left out.
async fn read(
    hub: &Hub,
    client: &Client,
    names: Option<&BTreeSet<String>>,
) -> BTreeMap<String, Value> {
    let concerned = |one: &Offered| {
        let is = |name: &String| {
            split(name).is_some_and(|(component, service, _)| {
                one.component == component && one.service.name == service
            })
        };
        is_parameter(one) && names.is_none_or(|names| names.iter().any(is))
    };
    let (by, mut values) = (client.asker(), BTreeMap::new());
    for Offered { component, service } in hub.offered(concerned) {
        let route = routes::service(&component, &service.name);
        let Ok(now) = hub.inside.ask(&by, &route, "").await else { continue };
        for input in now.parameters.into_iter().filter(|one| one.direction.is_input()) {
            let name = format!("/{component}/{}/{}", service.name, input.name);
            if let Some(value) = input.current
                && names.is_none_or(|names| names.contains(&name))
            {
                values.insert(name, value);
            }
        }
    }
    values
}

fn told(values: BTreeMap<String, Value>, id: Option<String>) -> Message {
    let parameters = values.into_iter().map(|(name, value)| parameter(name, &value));
    let message = ParameterValues { parameters: parameters.collect(), id };
    reply::json(&message)
}

/// What Foxglove needs to be told of the type besides the value: whether `1` is a real number.
fn parameter(name: String, value: &Value) -> Parameter {
    let real = |value: &Value| value.is_f64();
    let all_numbers = |all: &[Value]| all.iter().all(Value::is_number) && all.iter().any(real);
    let hint = match value {
        value if real(value) => Some(ParameterType::Float64),
        Value::Array(all) if all_numbers(all) => Some(ParameterType::Float64Array),
        _ => None,
    };
    Parameter { name, r#type: hint, value: converted(value) }
}

/// A value as Foxglove's parameters have it; they have no null.
fn converted(value: &Value) -> Option<ParameterValue> {
    Some(match value {
        Value::Null => return None,
        Value::Bool(value) => ParameterValue::Bool(*value),
        Value::Number(number) => match number.as_i64() {
            Some(integer) => ParameterValue::Integer(integer),
            None => ParameterValue::Float64(number.as_f64()?),
        },
        Value::String(text) => ParameterValue::String(text.clone()),
        Value::Array(all) => ParameterValue::Array(all.iter().filter_map(converted).collect()),
        Value::Object(all) => {
            let members = all.iter();
            let members = members.filter_map(|(key, one)| Some((key.clone(), converted(one)?)));
            ParameterValue::Dict(members.collect())
        }
    })
}

/// Does something that takes time beside what the client sends meanwhile.
fn beside<F, R>(hub: &Arc<Hub>, client: &Arc<Client>, work: F) -> Result<(), ParametersError>
where
    F: FnOnce(Arc<Hub>, Arc<Client>) -> R,
    R: Future<Output = ()> + Send + 'static,
{
    let Ok(permit) = Arc::clone(&client.calls).try_acquire_owned() else {
        return Err(ParametersError::Busy);
    };
    let work = work(Arc::clone(hub), Arc::clone(client));
    tokio::spawn(async move {
        work.await;
        drop(permit);
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_value_keeps_its_type() {
        for (value, hint) in [
            (json!(0.5), Some(ParameterType::Float64)),
            (json!(2.0), Some(ParameterType::Float64)),
            (json!(2), None),
            (json!([1.0, 2.0]), Some(ParameterType::Float64Array)),
            (json!(["a"]), None),
            (json!({"x": {"y": [true, false]}, "s": "t"}), None),
        ] {
            let made = parameter("/a/b/c".to_owned(), &value);
            assert_eq!(made.r#type, hint, "{value}");
            assert_eq!(serde_json::to_value(made.value.unwrap()).unwrap(), value);
        }
        assert_eq!(converted(&Value::Null), None);
    }

    #[test]
    fn a_name_has_three_parts() {
        assert_eq!(split("/demo/set_speed/velocity"), Some(("demo", "set_speed", "velocity")));
        for name in ["", "/", "/demo/set_speed", "demo/set_speed/velocity", "/a/b/c/d"] {
            assert_eq!(split(name), None, "{name}");
        }
    }
}
