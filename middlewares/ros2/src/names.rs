//! Names of ports, services and nodes in ROS 2. Names of types are made by [`genom_rosidl`].

use std::fmt::Write as _;

use genom_middleware::Address;
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

/// The ROS name of an address without its leading slash: `arm/demo/position`. An address without an
/// instance is absolute: `/scan` is `scan` in every namespace.
pub(crate) fn path(namespace: &str, at: &Address) -> String {
    let mut out = Vec::new();
    if !at.instance.is_empty() {
        let parts = namespace.split('/').filter(|part| !part.is_empty());
        out.extend(parts.map(str::to_owned));
        out.push(token(&at.instance));
    }
    out.extend(at.name.split('/').map(token));
    out.join("/")
}

/// The node of the in ports of this process.
pub(crate) fn own_node() -> String {
    format!("genomd_{}", std::process::id())
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
            assert_eq!(path("", &at), name);
        }
        assert_eq!(path("/lab/arm", &Address::new("demo", "p")), "lab/arm/demo/p");
        assert_eq!(path("/lab/arm", &Address::new("", "scan/left")), "scan/left");
    }
}
