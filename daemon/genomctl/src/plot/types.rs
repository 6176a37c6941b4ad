//! The type of a port, from what the control plane says of its layout: samples of recordings are read
//! with it.

use genom_protocol::PortType;
use genom_types::{DataType, Definition};
use serde_json::{Map, Value, json};

/// The type; `None` if this version of genomctl does not know it, or it contains natives.
pub(super) fn read(of: &PortType) -> Option<DataType> {
    let types: Option<Vec<Value>> = of.types.iter().map(kind).collect();
    let definition = json!({"types": types?, "digest": of.digest});
    serde_json::from_value::<Definition>(definition).ok()?.read().ok()
}

fn kind(ty: &Map<String, Value>) -> Option<Value> {
    let name = || -> Option<Vec<&str>> {
        let full = ty.get("full_name").or_else(|| ty.get("name"))?.as_str()?;
        Some(full.split("::").filter(|part| !part.is_empty()).collect())
    };
    let member = |one: &Value| json!({"name": one["name"], "ty": one["type"]});
    let members = || ty.get("members")?.as_array();
    let bound = || ty.get("bound").cloned().unwrap_or(Value::Null);
    Some(match ty.get("kind")?.as_str()? {
        "boolean" => json!("Boolean"),
        "char" => json!("Char"),
        "octet" => json!("Octet"),
        "short" => json!("Short"),
        "unsigned short" => json!("UnsignedShort"),
        "long" => json!("Long"),
        "unsigned long" => json!("UnsignedLong"),
        "long long" => json!("LongLong"),
        "unsigned long long" => json!("UnsignedLongLong"),
        "float" => json!("Float"),
        "double" => json!("Double"),
        "string" => json!({"String": {"bound": bound()}}),
        "array" => json!({"Array": {"element": ty.get("element")?, "length": ty.get("length")?}}),
        "sequence" => json!({"Sequence": {"element": ty.get("element")?, "bound": bound()}}),
        "optional" => json!({"Optional": {"element": ty.get("element")?}}),
        "enum" => json!({"Enum": {"name": name()?, "enumerators": ty.get("enumerators")?}}),
        "struct" => {
            let members: Vec<_> = members()?.iter().map(member).collect();
            json!({"Struct": {"name": name()?, "members": members}})
        }
        "union" => {
            let label = |label: &Value| match label {
                Value::Null => json!("Default"),
                value => json!({ "Value": value }),
            };
            let case = |one: &Value| {
                let labels: Option<Vec<_>> =
                    one["labels"].as_array().map(|all| all.iter().map(label).collect());
                json!({"name": one["name"], "ty": one["type"], "labels": labels})
            };
            let members: Vec<_> = members()?.iter().map(case).collect();
            let discriminant = ty.get("discriminant")?;
            json!({"Union": {"name": name()?, "discriminant": discriminant, "members": members}})
        }
        _ => return None,
    })
}
