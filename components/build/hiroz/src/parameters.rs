//! Parameters of other nodes, by the client that hiroz has, and `/parameter_events`.

use std::sync::Arc;

use hiroz::Builder as _;
use hiroz::msg::ZMessage;
use hiroz::node::ZNode;
use hiroz::parameter::wire_types::{WireParameterEvent, parameter_event_type_info};
use hiroz::parameter::{Parameter, ParameterClient, ParameterTarget, ParameterValue};
use hiroz::pubsub::ZSub;
use serde_json::{Value, json};
use tokio::runtime::Runtime;
use zenoh::sample::Sample;

use super::{Outcome, PATIENCE, Wrong, graph, text};

pub(crate) type Events = ZSub<WireParameterEvent, Sample, <WireParameterEvent as ZMessage>::Serdes>;

/// Of the node in this namespace and with this name: all that can be known of its parameters, after
/// this one was set to each of these numbers.
pub(crate) fn parameters(runtime: &Runtime, node: &Arc<ZNode>, given: &[Value]) -> Outcome {
    let target = ParameterTarget::new(text(given, 0)?, text(given, 1)?);
    let name = text(given, 2)?;
    let numbers = given.get(3).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let client = ParameterClient::new(Arc::clone(node), target)?;
    let work = async {
        let mut names = client.list(&[] as &[&str], None).await?.names;
        names.sort();
        let set = numbers.iter().filter_map(Value::as_f64);
        let set: Vec<_> =
            set.map(|number| Parameter::new(name, ParameterValue::Double(number))).collect();
        let set = client.set(&set).await?;
        let set: Vec<_> = set.iter().map(|one| json!([one.successful, one.reason])).collect();
        let value = match client.get(&[name]).await?.as_slice() {
            [ParameterValue::Double(value)] => json!(value),
            other => json!(format!("{other:?}")),
        };
        let types = client.get_types(&names).await?;
        let types: Vec<_> = types.iter().map(|one| format!("{one:?}")).collect();
        let described = client.describe(&names).await?;
        let told = |one: &hiroz::parameter::ParameterDescriptor| {
            let ty = format!("{:?}", one.type_);
            json!({"name": one.name, "type": ty, "description": one.description})
        };
        let described: Vec<_> = described.iter().map(told).collect();
        Ok(json!({
            "names": names, "set": set, "value": value, "types": types, "described": described,
        }))
    };
    runtime.block_on(work)
}

/// Of the node in this namespace and with this name: its parameters, as pairs of name and value.
pub(crate) fn dump(runtime: &Runtime, node: &Arc<ZNode>, given: &[Value]) -> Outcome {
    let client = client(node, given)?;
    let work = async {
        let mut names = client.list(&[] as &[&str], None).await?.names;
        names.sort();
        let values = client.get(&names).await?;
        let pairs: Vec<_> = names.iter().zip(values.iter().map(plain)).collect();
        Ok(json!(pairs))
    };
    runtime.block_on(work)
}

/// Sets such pairs, one after the other, or with `true` after them all or none.
pub(crate) fn load(runtime: &Runtime, node: &Arc<ZNode>, given: &[Value]) -> Outcome {
    let client = client(node, given)?;
    let pairs = given.get(2).and_then(Value::as_array).ok_or("give pairs of name and value")?;
    let parameter = |pair: &Value| Some(Parameter::new(pair[0].as_str()?, value(&pair[1])?));
    let all: Option<Vec<_>> = pairs.iter().map(parameter).collect();
    let all = all.ok_or("no parameter has such a value")?;
    if given.get(3) == Some(&json!(true)) {
        let told = runtime.block_on(client.set_atomically(&all))?;
        return Ok(json!([told.successful, told.reason]));
    }
    let told = runtime.block_on(client.set(&all))?;
    let told: Vec<_> = told.iter().map(|one| json!([one.successful, one.reason])).collect();
    Ok(json!(told))
}

/// A client of the parameters of a node, as soon as that serves them all.
fn client(node: &Arc<ZNode>, given: &[Value]) -> Result<ParameterClient, Wrong> {
    let target = ParameterTarget::new(text(given, 0)?, text(given, 1)?);
    for service in
        ["list_parameters", "get_parameters", "set_parameters", "set_parameters_atomically"]
    {
        graph::served(node, &format!("{}/{service}", target.fully_qualified_name()))?;
    }
    ParameterClient::new(Arc::clone(node), target)
}

fn plain(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::NotSet => Value::Null,
        ParameterValue::Bool(value) => json!(value),
        ParameterValue::Integer(value) => json!(value),
        ParameterValue::Double(value) => json!(value),
        ParameterValue::String(value) => json!(value),
        ParameterValue::ByteArray(values) => json!(values),
        ParameterValue::BoolArray(values) => json!(values),
        ParameterValue::IntegerArray(values) => json!(values),
        ParameterValue::DoubleArray(values) => json!(values),
        ParameterValue::StringArray(values) => json!(values),
    }
}

/// The value that YAML of `ros2 param dump` would mean: numbers with a fraction are of double.
fn value(plain: &Value) -> Option<ParameterValue> {
    Some(match plain {
        Value::Bool(value) => ParameterValue::Bool(*value),
        Value::String(value) => ParameterValue::String(value.clone()),
        Value::Number(number) => match number.as_i64() {
            Some(value) => ParameterValue::Integer(value),
            None => ParameterValue::Double(number.as_f64()?),
        },
        Value::Array(values) => {
            let numbers: Option<_> = values.iter().map(Value::as_i64).collect();
            ParameterValue::IntegerArray(numbers?)
        }
        Value::Null | Value::Object(_) => return None,
    })
}

pub(crate) fn events(node: &ZNode) -> Result<Events, Wrong> {
    let ty = Some(parameter_event_type_info());
    node.create_sub_impl::<WireParameterEvent>("/parameter_events", ty).build()
}

/// The next one: of which node, and which of its parameters have which numbers now.
pub(crate) fn event(events: &Events) -> Outcome {
    let event = events.recv_timeout(PATIENCE)?;
    let all = event.new_parameters.iter().chain(&event.changed_parameters);
    let all: Vec<_> = all.map(|one| json!([one.name, one.value.double_value])).collect();
    Ok(json!({"node": event.node, "parameters": all, "deleted": event.deleted_parameters.len()}))
}
