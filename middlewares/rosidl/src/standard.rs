//! Messages, services and actions of ROS itself, by name, for types that masquerade as them.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::interface::{Interface, Message};
use crate::names::TypeName;
use crate::parse::parse;

/// `== package/folder/Name`, followed by its members, without comments and constants.
const TEXT: &str = include_str!("standard.txt");

static ALL: LazyLock<BTreeMap<TypeName, Interface>> = LazyLock::new(|| {
    let texts = TEXT.split("== ").skip(1).filter_map(|one| one.split_once('\n'));
    let read = |(name, text): (&str, &str)| {
        let name = TypeName::parse(name.trim())?;
        let interface = parse(&name, text).ok()?;
        Some((name, interface))
    };
    texts.filter_map(read).collect()
});

/// All definitions.
pub(crate) fn all() -> &'static BTreeMap<TypeName, Interface> {
    &ALL
}

/// The definition of a message.
pub(crate) fn message(name: &TypeName) -> Option<Message> {
    match ALL.get(name) {
        Some(Interface::Message(message)) => Some(message.clone()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::Base;

    #[test]
    fn all_can_be_read_and_refer_to_each_other() {
        assert_eq!(all().len(), TEXT.matches("== ").count());
        for interface in all().values() {
            for field in interface.parts().flat_map(|part| &part.fields) {
                if let Base::Message(name) = &field.base {
                    assert!(message(name).is_some(), "{} needs {name}", interface.name());
                }
            }
        }
    }
}
