//! The memory layout of a port's type, for programs that share memory with the daemon.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::type_kind::TypeKind;

/// The type of a port, with all types that it consists of.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortType {
    /// Name of the type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Digest of the type; ports of equal digest can be connected.
    pub digest: String,
    /// The type as ROS 2 and recordings know it.
    pub message: MessageType,
    /// The type itself, then the types that it consists of: `kind`, `name`, `size` and `align` in
    /// bytes, `fixed`, and further members that depend on the kind. They refer to each other by
    /// index in this list.
    #[cfg_attr(feature = "openapi", schema(value_type = Vec<Object>))]
    pub types: Vec<Map<String, Value>>,
}

impl PortType {
    /// What its [types](Self::types) are made of; `None` if one is of a kind that is not known here,
    /// or has no values of its own: natives.
    #[must_use]
    pub fn kinds(&self) -> Option<Vec<TypeKind>> {
        let kind = |ty: &Map<String, Value>| serde_json::from_value(ty.clone().into()).ok();
        self.types.iter().map(kind).collect()
    }
}

/// A type as a ROS 2 message.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MessageType {
    /// `PACKAGE/msg/NAME`.
    pub name: String,
    /// Its definition, followed by those of the messages it contains; absent if the type contains a
    /// native.
    pub definition: Option<String>,
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::type_kind::TypeMember;

    fn described(types: Value) -> PortType {
        let message = json!({"name": "m/msg/T", "definition": null});
        let described = json!({"type": "t", "digest": "d", "message": message, "types": types});
        serde_json::from_value(described).unwrap()
    }

    #[test]
    fn the_kinds_of_a_type_are_read_from_its_layout() {
        let of = described(json!([
            {"kind": "union", "name": "u", "full_name": "::m::u", "size": 16, "align": 8, "fixed": true,
             "discriminant": 1, "members": [
                {"name": "a", "offset": 8, "type": 2, "labels": [-1, u64::MAX]},
                {"name": "b", "offset": 8, "type": 3, "labels": [null]}]},
            {"kind": "unsigned long long", "name": "unsigned long long", "size": 8, "align": 8},
            {"kind": "sequence", "name": "sequence<double>", "bound": null, "element": 3},
            {"kind": "double", "name": "double"},
        ]));
        let member = |name: &str, ty, labels| TypeMember { name: name.to_owned(), ty, labels };
        let labels = vec![Some((-1).into()), Some(u64::MAX.into())];
        let union = TypeKind::Union {
            full_name: "::m::u".to_owned(),
            discriminant: 1,
            members: vec![member("a", 2, labels), member("b", 3, vec![None])],
        };
        let list = TypeKind::Sequence { element: 3, bound: None };
        let wanted = vec![union, TypeKind::UnsignedLongLong, list, TypeKind::Double];
        assert_eq!(of.kinds(), Some(wanted));
    }

    #[test]
    fn a_native_has_no_kind() {
        let of = described(json!([{"kind": "native", "name": "n", "full_name": "::m::n"}]));
        assert_eq!(of.kinds(), None);
    }
}
