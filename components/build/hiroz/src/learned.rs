//! Topics whose types hiroz does not know until their writer describes them: it makes a structure
//! and the hash of it from the description, and takes messages apart by that.

use hiroz::Builder as _;
use hiroz::dynamic::{DynSub, DynamicMessage, DynamicValue, MessageSchemaTypeDescription as _};
use hiroz::node::ZNode;
use serde_json::{Map, Value, json};
use tokio::runtime::Runtime;

use super::{Outcome, PATIENCE, Wrong, transient_local};

/// Asks the writer of a topic for its type, and reads it under the hash that follows from the
/// description: with another one nothing arrives.
pub(crate) fn learn(
    runtime: &Runtime,
    node: &ZNode,
    topic: &str,
    given: &[Value],
) -> Result<(DynSub, Value), Wrong> {
    let found = runtime.block_on(node.discover_topic_schema(topic, PATIENCE))?;
    let hash = found.schema.compute_type_hash()?.to_rihs_string();
    let told = json!({"type": found.schema.type_name, "told": found.type_hash, "hash": hash});
    let mut reader = node.create_dyn_sub(topic, found.schema);
    if given.get(1) == Some(&json!(true)) {
        reader = reader.with_qos(transient_local());
    }
    Ok((reader.build()?, told))
}

pub(crate) fn next(reader: &DynSub) -> Outcome {
    Ok(message(&reader.recv_timeout(PATIENCE)?))
}

/// The next one, if it has arrived already.
pub(crate) fn any(reader: &DynSub) -> Outcome {
    if reader.is_ready() { next(reader) } else { Ok(Value::Null) }
}

fn message(of: &DynamicMessage) -> Value {
    let members = of.iter().map(|(name, one)| (name.to_owned(), value(one)));
    Value::Object(members.collect::<Map<_, _>>())
}

fn value(of: &DynamicValue) -> Value {
    match of {
        DynamicValue::Bool(one) => json!(one),
        DynamicValue::Int8(one) => json!(one),
        DynamicValue::Int16(one) => json!(one),
        DynamicValue::Int32(one) => json!(one),
        DynamicValue::Int64(one) => json!(one),
        DynamicValue::Uint8(one) => json!(one),
        DynamicValue::Uint16(one) => json!(one),
        DynamicValue::Uint32(one) => json!(one),
        DynamicValue::Uint64(one) => json!(one),
        DynamicValue::Float32(one) => json!(one),
        DynamicValue::Float64(one) => json!(one),
        DynamicValue::String(one) => json!(one),
        DynamicValue::Bytes(one) => json!(one),
        DynamicValue::Message(one) => message(one),
        DynamicValue::Array(all) => all.iter().map(value).collect(),
    }
}
