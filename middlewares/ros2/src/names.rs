//! What things are called in ROS 2: topics, services and types, and their names in DDS.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use genom_middleware::Address;
use genom_types::message::{ANONYMOUS, MessageName, camel, name_in, package};
use genom_types::{DataType, Kind, TypeId, TypeTable};

/// A ROS type such as `demo/msg/State`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TypeName {
    pub(crate) package: String,
    /// `msg`, `srv` or `action`.
    pub(crate) folder: String,
    pub(crate) name: String,
}

impl TypeName {
    pub(crate) fn new(package: &str, folder: &str, name: &str) -> Self {
        Self { package: package.to_owned(), folder: folder.to_owned(), name: name.to_owned() }
    }

    /// Reads `geometry_msgs/msg/Pose`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split('/');
        let (package, folder, name) = (parts.next()?, parts.next()?, parts.next()?);
        let legal = |part: &str| {
            part.starts_with(|c: char| c.is_ascii_alphabetic())
                && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        let known = ["msg", "srv", "action"].contains(&folder);
        (parts.next().is_none() && known && legal(package) && legal(name))
            .then(|| Self::new(package, folder, name))
    }

    /// How DDS spells it: `demo::msg::dds_::State_`, with a suffix for the parts of services.
    pub(crate) fn to_dds(&self, suffix: &str) -> String {
        format!("{}::{}::dds_::{}{suffix}_", self.package, self.folder, self.name)
    }

    /// The ROS spelling of a DDS name, as it is when it is none of ROS.
    pub(crate) fn from_dds(name: &str) -> String {
        let parts = name.strip_suffix('_').and_then(|name| name.split_once("::dds_::"));
        match parts {
            Some((scope, name)) => format!("{}/{name}", scope.replace("::", "/")),
            None => name.to_owned(),
        }
    }
}

/// The message a port of this type carries.
pub(crate) fn message(ty: &DataType, masquerade: &BTreeMap<String, String>) -> TypeName {
    let foreign = masquerade.get(ty.name()).and_then(|name| TypeName::parse(name));
    foreign.unwrap_or_else(|| message_of(ty.table(), ty.id()))
}

fn message_of(table: &TypeTable, id: TypeId) -> TypeName {
    let MessageName { package, name } = name_in(table, id);
    TypeName { package, folder: "msg".to_owned(), name }
}

/// The type of a service: its input struct is `::component::service::input`.
pub(crate) fn service(input: &DataType, at: &Address, folder: &str) -> TypeName {
    match input.kind() {
        Kind::Struct { name, .. } => match name.segments() {
            [component, service @ .., last] if last == "input" && !service.is_empty() => {
                let service = camel(service.iter().map(String::as_str));
                TypeName::new(&package(component), folder, &service)
            }
            [component, ..] => {
                TypeName::new(&package(component), folder, &camel([at.name.as_str()]))
            }
            [] => TypeName::new(ANONYMOUS, folder, &camel([at.name.as_str()])),
        },
        _ => TypeName::new(ANONYMOUS, folder, &camel([at.name.as_str()])),
    }
}

/// The ROS name of an address, without the first slash: `arm/demo/position`.
pub(crate) fn path(namespace: &str, at: &Address) -> String {
    let parts = namespace.split('/').filter(|part| !part.is_empty());
    let mut out: Vec<String> = parts.map(str::to_owned).collect();
    out.push(token(&at.instance));
    out.extend(at.name.split('/').map(token));
    out.join("/")
}

/// A token of a ROS name. Characters ROS does not allow become `_xHH`, and so does what would
/// read like that.
pub(crate) fn token(text: &str) -> String {
    let mut out = String::new();
    let bytes = text.as_bytes();
    for (i, &byte) in bytes.iter().enumerate() {
        let hexadecimal = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_hexdigit);
        let escape = byte == b'_'
            && bytes.get(i + 1) == Some(&b'x')
            && hexadecimal(i + 2)
            && hexadecimal(i + 3);
        let legal = match byte {
            b'_' => !escape,
            b'0'..=b'9' => i > 0,
            _ => byte.is_ascii_alphabetic(),
        };
        if legal {
            out.push(char::from(byte));
        } else {
            _ = write!(out, "_x{byte:02x}");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_types::ScopedName;

    #[test]
    fn addresses_become_legal_ros_names_and_stay_apart() {
        for (at, name) in [
            (Address::new("demo", "position"), "demo/position"),
            (Address::new("demo", "poses/far.left"), "demo/poses/far_x2eleft"),
            (Address::new("demo", "poses/far_x2eleft"), "demo/poses/far_x5fx2eleft"),
            (Address::new("demo", "poses/1"), "demo/poses/_x31"),
            (Address::new("robot-1", "a_b"), "robot_x2d1/a_b"),
        ] {
            assert_eq!(path("", &at), name);
        }
        assert_eq!(path("/lab/arm", &Address::new("demo", "p")), "lab/arm/demo/p");
    }

    #[test]
    fn packages_are_legal() {
        for (scope, name) in [
            ("demo", "demo"),
            ("or_pose_estimator", "or_pose_estimator"),
            ("Demo", "genom_demo"),
            ("_x", "genom__x"),
        ] {
            assert_eq!(package(scope), name);
        }
    }

    #[test]
    fn types_are_named_after_their_scope_or_as_the_standard_messages() {
        let mut table = TypeTable::default();
        let state = ScopedName::new(["or_pose", "track", "arm_state"]);
        let cases = [
            (Kind::Struct { name: state, members: vec![] }, "or_pose/msg/TrackArmState"),
            (Kind::Double, "std_msgs/msg/Float64"),
            (Kind::String { bound: Some(8) }, "std_msgs/msg/String"),
        ];
        for (kind, ros) in cases {
            let id = table.add(kind);
            let name = message_of(&table, id);
            assert_eq!(TypeName::from_dds(&name.to_dds("")), ros);
            assert_eq!(TypeName::parse(ros), Some(name));
        }
        let double = table.add(Kind::Double);
        let row = table.add(Kind::Sequence { element: double, bound: Some(3) });
        let name = ScopedName::new(["demo", "row"]);
        let named = table.add(Kind::Typedef { name, target: row });
        assert_eq!(message_of(&table, row).to_dds(""), "genom_types::msg::dds_::Sequence3Double_");
        assert_eq!(message_of(&table, named).to_dds(""), "demo::msg::dds_::Row_");
    }
}
