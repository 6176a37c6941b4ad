//! Names of ports, services and nodes in ROS 2. Names of types are made by [`genom_rosidl`].

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{PoisonError, RwLock};

use genom_middleware::{Address, NoForeignName};
pub(crate) use genom_rosidl::TypeName;
use genom_types::DataType;

/// The message of a port that does not masquerade.
pub(crate) fn message(ty: &DataType) -> TypeName {
    genom_rosidl::message(ty.table(), ty.id())
}

/// The type of a service, named after its input struct.
pub(crate) fn service(input: &DataType, at: &Address, folder: &str) -> TypeName {
    genom_rosidl::service(input.table(), input.id(), &at.name, folder)
}

/// Names of components, and of their ports and services.
pub(crate) struct Names {
    /// Of all nodes that have no other, without slashes around it: `lab/arm`.
    namespace: String,
    /// Other names than those that follow from the address: of instances (`demo`), and of addresses
    /// (`demo/position`).
    given: RwLock<BTreeMap<String, String>>,
}

impl Names {
    pub(crate) fn new(namespace: &str) -> Self {
        Self { namespace: namespace.trim_matches('/').to_owned(), given: RwLock::default() }
    }

    /// The full name of the node of a component, without its leading slash: `lab/arm/demo`.
    pub(crate) fn node(&self, instance: &str) -> String {
        match self.given(instance).as_deref() {
            Some(name) => match name.strip_prefix('/') {
                Some(absolute) => absolute.to_owned(),
                None => joined(&self.namespace, name),
            },
            None => joined(&self.namespace, &token(instance)),
        }
    }

    /// The node of the in ports of this process.
    pub(crate) fn own_node(&self) -> String {
        joined(&self.namespace, &format!("genomd_{}", std::process::id()))
    }

    /// The ROS name of an address without its leading slash: `lab/arm/demo/position`. An address
    /// without an instance is absolute: `/scan` is `scan` in every namespace.
    pub(crate) fn path(&self, at: &Address) -> String {
        if let Some(given) = self.given_to(at) {
            return given;
        }
        let own = at.name.split('/').map(token).collect::<Vec<_>>().join("/");
        if at.instance.is_empty() { own } else { joined(&self.node(&at.instance), &own) }
    }

    /// The address as other daemons spell it: with the namespace in front, or as its ROS name if it
    /// has one of its own.
    pub(crate) fn full(&self, at: &Address) -> String {
        if at.instance.is_empty() {
            return at.name.clone();
        }
        let elsewhere = || self.given(&at.instance).map(|_| self.path(at));
        let given = self.given_to(at).or_else(elsewhere);
        given.unwrap_or_else(|| joined(&self.namespace, &at.to_string()))
    }

    /// From now on, an instance or an address has this name.
    pub(crate) fn give(&self, ours: &str, name: &str) -> Result<(), NoForeignName> {
        let plain = name.strip_prefix("~/").or_else(|| name.strip_prefix('/')).unwrap_or(name);
        let legal = |part: &str| {
            !part.starts_with(|c: char| c.is_ascii_digit())
                && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if !plain.split('/').all(|part| !part.is_empty() && legal(part)) {
            return Err(NoForeignName {
                ours: ours.to_owned(),
                foreign: name.to_owned(),
                form: "/lab/name".into(),
            });
        }
        let mut given = self.given.write().unwrap_or_else(PoisonError::into_inner);
        given.insert(ours.to_owned(), name.to_owned());
        Ok(())
    }

    /// Undoes that.
    pub(crate) fn take_back(&self, ours: &str) {
        self.given.write().unwrap_or_else(PoisonError::into_inner).remove(ours);
    }

    fn given(&self, ours: &str) -> Option<String> {
        self.given.read().unwrap_or_else(PoisonError::into_inner).get(ours).cloned()
    }

    /// The name that was given to an address: absolute, or below its node or the node's namespace.
    fn given_to(&self, at: &Address) -> Option<String> {
        let given = self.given(&at.to_string())?;
        if let Some(absolute) = given.strip_prefix('/') {
            return Some(absolute.to_owned());
        }
        let node = self.node(&at.instance);
        Some(match given.strip_prefix("~/") {
            Some(private) => joined(&node, private),
            None => joined(split(&node).0, &given),
        })
    }
}

/// Whether a name that is to be shown as another is that of a type or a service type, not of an
/// instance or a port.
pub(crate) fn is_type(ours: &str) -> bool {
    ours.starts_with("::")
}

/// Namespace and name of a node, without the leading slash of the namespace.
pub(crate) fn split(node: &str) -> (&str, &str) {
    node.rsplit_once('/').unwrap_or(("", node))
}

fn joined(before: &str, name: &str) -> String {
    if before.is_empty() { name.to_owned() } else { format!("{before}/{name}") }
}

/// A token of a ROS name. Characters that ROS does not allow become `_xHH`, and so does text that
/// could be mistaken for such an escape.
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

    #[test]
    fn addresses_become_legal_ros_names_and_stay_apart() {
        for (at, name) in [
            (Address::new("demo", "position"), "demo/position"),
            (Address::new("demo", "poses/far.left"), "demo/poses/far_x2eleft"),
            (Address::new("demo", "poses/far_x2eleft"), "demo/poses/far_x5fx2eleft"),
            (Address::new("demo", "poses/1"), "demo/poses/_x31"),
            (Address::new("robot-1", "a_b"), "robot_x2d1/a_b"),
        ] {
            assert_eq!(Names::new("").path(&at), name);
        }
        let names = Names::new("/lab/arm");
        assert_eq!(names.path(&Address::new("demo", "p")), "lab/arm/demo/p");
        assert_eq!(names.path(&Address::new("", "scan/left")), "scan/left");
        assert_eq!(names.full(&Address::new("demo", "far.p")), "lab/arm/demo/far.p");
    }
    #[test]
    fn names_that_were_given_are_absolute_or_below_the_node_or_its_namespace() {
        let names = Names::new("lab");
        let (p, q) = (Address::new("demo", "p"), Address::new("demo", "q"));
        let give = |ours: &str, name: &str| names.give(ours, name).unwrap();
        give("demo/p", "/odom");
        assert_eq!((names.path(&p), names.path(&q)), ("odom".into(), "lab/demo/q".into()));
        assert_eq!((names.full(&p), names.full(&q)), ("odom".into(), "lab/demo/q".into()));
        give("demo", "/base/arm");
        assert_eq!(names.node("demo"), "base/arm");
        assert_eq!((names.path(&p), names.path(&q)), ("odom".into(), "base/arm/q".into()));
        assert_eq!(names.full(&q), "base/arm/q");
        give("demo/p", "odom");
        give("demo/q", "~/deep/q");
        assert_eq!(
            (names.path(&p), names.path(&q)),
            ("base/odom".into(), "base/arm/deep/q".into())
        );
        give("demo", "arm");
        assert_eq!(names.node("demo"), "lab/arm");
        ["demo", "demo/p", "demo/q"].iter().for_each(|ours| names.take_back(ours));
        assert_eq!(names.path(&p), "lab/demo/p");
        for wrong in ["", "/", "//odom", "2odom", "a b", "/odom/"] {
            assert!(names.give("demo/p", wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_node_has_a_namespace_and_a_name() {
        assert_eq!(split("lab/arm/demo"), ("lab/arm", "demo"));
        assert_eq!(split("demo"), ("", "demo"));
    }
}
