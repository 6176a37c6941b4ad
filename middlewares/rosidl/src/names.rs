//! Names of types in ROS 2 and in DDS.

use std::collections::BTreeMap;
use std::fmt;

use genom_types::message::{self, ANONYMOUS, MessageName, camel, package};
use genom_types::{Kind, ScopedName, TypeId, TypeTable};

/// A ROS type such as `demo/msg/State`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TypeName {
    /// Name of the package.
    pub package: String,
    /// `msg`, `srv` or `action`.
    pub folder: String,
    /// Name within the package.
    pub name: String,
}

impl fmt::Display for TypeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.package, self.folder, self.name)
    }
}

impl TypeName {
    /// Builds a name from its parts.
    #[must_use]
    pub fn new(package: &str, folder: &str, name: &str) -> Self {
        Self { package: package.to_owned(), folder: folder.to_owned(), name: name.to_owned() }
    }

    fn of(MessageName { package, name }: MessageName, folder: &str) -> Self {
        Self { package, folder: folder.to_owned(), name }
    }

    /// Parses a name such as `geometry_msgs/msg/Pose`.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
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

    /// The DDS name: `demo::msg::dds_::State_`; `suffix` is for the parts of services.
    #[must_use]
    pub fn to_dds(&self, suffix: &str) -> String {
        format!("{}::{}::dds_::{}{suffix}_", self.package, self.folder, self.name)
    }

    /// The ROS name for a DDS name; the DDS name itself if it does not have ROS's form.
    #[must_use]
    pub fn from_dds(name: &str) -> String {
        let parts = name.strip_suffix('_').and_then(|name| name.split_once("::dds_::"));
        match parts {
            Some((scope, name)) => format!("{}/{name}", scope.replace("::", "/")),
            None => name.to_owned(),
        }
    }

    /// A part of this service or action, such as `_Request` or `_SendGoal`.
    #[must_use]
    pub fn part(&self, suffix: &str) -> Self {
        Self { name: format!("{}{suffix}", self.name), ..self.clone() }
    }
}

/// The message that a port of this type carries.
#[must_use]
pub fn message(table: &TypeTable, id: TypeId) -> TypeName {
    TypeName::of(message::name_in(table, id), "msg")
}

/// What a type masquerades as, looked up by its full name or by that of the type it is a typedef
/// of.
#[must_use]
pub fn masqueraded<'m, T>(
    table: &TypeTable,
    mut ty: TypeId,
    masquerades: &'m BTreeMap<String, T>,
) -> Option<&'m T> {
    for _ in 0..=table.len() {
        let kind = table.kind(ty);
        let found = kind.name().and_then(|name| masquerades.get(&name.to_string()));
        match (found, kind) {
            (None, Kind::Typedef { target, .. }) => ty = *target,
            (found, _) => return found,
        }
    }
    None
}

/// Package and name for a scoped name: `::or_pose::track::state` becomes `or_pose/msg/TrackState`.
fn scoped(name: &ScopedName, folder: &str) -> TypeName {
    TypeName::of(message::scoped(name), folder)
}

/// Full name of the service whose input struct this is: `::component::service` for
/// `::component::service::input`.
#[must_use]
pub fn service_of(table: &TypeTable, input: TypeId) -> Option<ScopedName> {
    match table.resolved(input) {
        Kind::Struct { name, .. } => match name.segments() {
            [service @ .., last] if last == "input" && service.len() > 1 => {
                Some(ScopedName::new(service))
            }
            _ => None,
        },
        _ => None,
    }
}

/// The type of the service with this input struct. `folder` is `srv` or `action`; `name` is used if
/// the struct does not say the service's name.
#[must_use]
pub fn service(table: &TypeTable, input: TypeId, name: &str, folder: &str) -> TypeName {
    if let Some(service) = service_of(table, input) {
        return scoped(&service, folder);
    }
    match table.resolved(input).name().and_then(|name| name.segments().first()) {
        Some(component) => TypeName::new(&package(component), folder, &camel([name])),
        None => TypeName::new(ANONYMOUS, folder, &camel([name])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let name = message(&table, id);
            assert_eq!(TypeName::from_dds(&name.to_dds("")), ros);
            assert_eq!(TypeName::parse(ros), Some(name));
        }
        let double = table.add(Kind::Double);
        let row = table.add(Kind::Sequence { element: double, bound: Some(3) });
        let name = ScopedName::new(["demo", "row"]);
        let named = table.add(Kind::Typedef { name, target: row });
        assert_eq!(message(&table, row).to_dds(""), "genom_types::msg::dds_::Sequence3Double_");
        assert_eq!(message(&table, named).to_dds(""), "demo::msg::dds_::Row_");
    }
}
