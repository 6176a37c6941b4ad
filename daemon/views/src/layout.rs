//! The memory layout of a type, for programs that share memory with the daemon.

use genom_protocol::{MessageType, PortType};
use genom_types::{DataType, Outline, message};

/// Describes a type and all types that it consists of, itself first.
pub fn of(ty: &DataType) -> PortType {
    let mut outline = Outline::default();
    outline.place(ty.clone());
    PortType {
        ty: ty.name().to_owned(),
        digest: ty.digest().to_owned(),
        message: MessageType {
            name: message::message_name(ty).to_string(),
            definition: message::message_definition(ty),
        },
        types: outline.types(),
    }
}
