//! What recordings say of a channel before its samples.

use genom_description::model::PortDirection;
use genom_middleware::Address;
use genom_protocol::frames::Channel;
use genom_types::{DataType, message};

use super::notes::SUBJECTS;

/// The head of a port; `None` if its type has native members, which cannot be recorded. Who sends or
/// writes it assigns its number.
pub(crate) fn of_port(
    address: &Address,
    of: PortDirection,
    reads: Option<&Address>,
    ty: &DataType,
) -> Option<Channel> {
    let definition = message::message_definition(ty)?;
    let metadata = [
        ("direction", Some(of.as_str().to_owned())),
        ("type", Some(ty.name().to_owned())),
        ("reads", reads.map(Address::to_string)),
    ];
    let metadata = metadata.into_iter();
    Some(Channel {
        channel: 0,
        topic: format!("/{address}"),
        encoding: "cdr".to_owned(),
        schema: message::message_name(ty).to_string(),
        definition,
        metadata: metadata.filter_map(|(key, value)| Some((key.to_owned(), value?))).collect(),
    })
}

/// The channels of what the daemon reports itself.
pub(crate) fn of_events() -> Vec<Channel> {
    SUBJECTS.iter().map(|subject| subject.head()).collect()
}
