//! The type of a port, from what the control plane says of its layout: samples of recordings are read
//! with it.

use genom_protocol::{PortType, TypeKind, TypeMember};
use genom_types::{DataType, Definition};
use serde_json::{Value, json};

/// The type; `None` if this version of genomctl does not know it, or it contains natives.
pub(super) fn read(of: &PortType) -> Option<DataType> {
    let types: Vec<Value> = of.kinds()?.iter().map(kind).collect();
    let definition = json!({"types": types, "digest": of.digest});
    serde_json::from_value::<Definition>(definition).ok()?.read().ok()
}

/// A kind as definitions have it.
fn kind(ty: &TypeKind) -> Value {
    match ty {
        TypeKind::Boolean => json!("Boolean"),
        TypeKind::Char => json!("Char"),
        TypeKind::Octet => json!("Octet"),
        TypeKind::Short => json!("Short"),
        TypeKind::UnsignedShort => json!("UnsignedShort"),
        TypeKind::Long => json!("Long"),
        TypeKind::UnsignedLong => json!("UnsignedLong"),
        TypeKind::LongLong => json!("LongLong"),
        TypeKind::UnsignedLongLong => json!("UnsignedLongLong"),
        TypeKind::Float => json!("Float"),
        TypeKind::Double => json!("Double"),
        TypeKind::String { bound } => json!({"String": {"bound": bound}}),
        TypeKind::Array { element, length } => {
            json!({"Array": {"element": element, "length": length}})
        }
        TypeKind::Sequence { element, bound } => {
            json!({"Sequence": {"element": element, "bound": bound}})
        }
        TypeKind::Optional { element } => json!({"Optional": {"element": element}}),
        TypeKind::Enum { full_name, enumerators } => {
            json!({"Enum": {"name": segments(full_name), "enumerators": enumerators}})
        }
        TypeKind::Struct { full_name, members } => {
            let member = |one: &TypeMember| json!({"name": one.name, "ty": one.ty});
            let members: Vec<_> = members.iter().map(member).collect();
            json!({"Struct": {"name": segments(full_name), "members": members}})
        }
        TypeKind::Union { full_name, discriminant, members } => {
            let case = |one: &TypeMember| {
                let label = |label: &Option<_>| match label {
                    None => json!("Default"),
                    Some(value) => json!({ "Value": value }),
                };
                let labels: Vec<_> = one.labels.iter().map(label).collect();
                json!({"name": one.name, "ty": one.ty, "labels": labels})
            };
            let members: Vec<_> = members.iter().map(case).collect();
            let name = segments(full_name);
            json!({"Union": {"name": name, "discriminant": discriminant, "members": members}})
        }
    }
}

/// The segments of `::SCOPE::NAME`.
fn segments(name: &str) -> Vec<&str> {
    name.split("::").filter(|part| !part.is_empty()).collect()
}
