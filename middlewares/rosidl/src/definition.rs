//! Definitions as recordings hold them (`ros2msg` of `rosbag2` and MCAP): a message, and all
//! messages inside it, in one text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use genom_types::DataType;

use crate::interface::Interface;
use crate::map::{MapError, Mapper};
use crate::names;

/// Between the definitions of a text, the first of which is the message itself.
const RULE: &str =
    "================================================================================";

/// The message of a type, and its definition with all messages in it.
///
/// # Errors
/// The type, or one inside it, has no equivalent in ROS.
pub fn definition(ty: &DataType) -> Result<(names::TypeName, String), MapError> {
    let table = ty.table();
    let name = names::message(table, ty.id());
    let mut mapper = Mapper::new(table, BTreeMap::new());
    let mut out = mapper.fields(&name, ty.id())?.to_string();
    for interface in mapper.finish() {
        if let Interface::Message(message) = interface {
            let inner = &message.name;
            _ = write!(out, "{RULE}\nMSG: {}/{}\n{message}", inner.package, inner.name);
        }
    }
    Ok((name, out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use genom_types::{Kind, Label, Member, ScopedName, TypeId, TypeTable, UnionMember};

    fn member(name: &str, ty: TypeId) -> Member {
        Member { name: name.to_owned(), ty }
    }

    #[test]
    fn a_basic_type_is_a_standard_message() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let (name, text) = definition(&ty).unwrap();
        assert_eq!((name.to_string().as_str(), &*text), ("std_msgs/msg/Float64", "float64 data\n"));
    }

    #[test]
    fn a_struct_defines_all_it_is_made_of() {
        let mut table = TypeTable::default();
        let double = table.add(Kind::Double);
        let row = table.add(Kind::Array { element: double, length: 3 });
        let matrix = table.add(Kind::Array { element: row, length: 2 });
        let text = table.add(Kind::String { bound: Some(8) });
        let path = table.add(Kind::Sequence { element: double, bound: None });
        let paths = table.add(Kind::Sequence { element: path, bound: Some(4) });
        let mode = table.add(Kind::Enum {
            name: ScopedName::new(["demo", "mode"]),
            enumerators: vec!["IDLE".into(), "Moving".into()],
        });
        let label = vec![Label::Default];
        let some = table.add(Kind::Union {
            name: ScopedName::new(["demo", "some"]),
            discriminant: mode,
            members: vec![UnionMember { name: "at".into(), ty: double, labels: label }],
        });
        let maybe = table.add(Kind::Optional { element: some });
        let members = vec![
            member("M_", matrix),
            member("name", text),
            member("paths", paths),
            member("maybe", maybe),
        ];
        let name = ScopedName::new(["demo", "arm", "state"]);
        let id = table.add(Kind::Struct { name, members });
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let (name, text) = definition(&ty).unwrap();
        assert_eq!(name.to_string(), "demo/msg/ArmState");
        let wanted = format!(
            "# ::demo::arm::state\nfloat64[6] m  # IDL: M_\nstring<=7 name\n\
             demo/SequenceDouble[<=4] paths\ndemo/Some[<=1] maybe\n{RULE}\n\
             MSG: demo/SequenceDouble\nfloat64[] data\n{RULE}\nMSG: demo/Some\n# ::demo::some\n\
             uint32 MODE_IDLE=0\nuint32 MODE_MOVING=1\nuint32 genom_discriminant\n\
             float64[<=1] at\n"
        );
        assert_eq!(text, wanted);
    }

    #[test]
    fn a_native_has_no_message() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Native { name: ScopedName::new(["demo", "handle"]) });
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        assert!(definition(&ty).is_err());
    }
}
