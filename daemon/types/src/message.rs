//! Types as ROS 2 messages: their names, and their definitions as text.
//!
//! The text describes exactly what [`cdr`](crate::cdr) encodes, so that a ROS 2 reader can decode
//! it. Where ROS has no such field type, a sequence of sequences for instance, it is wrapped in a
//! message with one member `data`, which adds no bytes in CDR.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::data_type::DataType;
use crate::kind::{Kind, ScopedName, TypeId};
use crate::table::TypeTable;

/// Package of types that belong to no component: anonymous ones.
pub const ANONYMOUS: &str = "genom_types";

/// Separates the definitions of a text; the first one is the message itself.
const RULE: &str =
    "================================================================================";

/// Package and name of a message, such as `demo` and `State` of `demo/msg/State`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MessageName {
    /// The package: the outermost scope.
    pub package: String,
    /// The name: the other scopes, in camel case.
    pub name: String,
}

impl std::fmt::Display for MessageName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/msg/{}", self.package, self.name)
    }
}

/// Name of the message that stands for a type.
#[must_use]
pub fn message_name(ty: &DataType) -> MessageName {
    name_in(ty.table(), ty.id())
}

/// Definition of a type's message and of all messages in it, as `rosbag2` and MCAP write them
/// (`ros2msg`); `None` for a type that has a native inside.
#[must_use]
pub fn message_definition(ty: &DataType) -> Option<String> {
    let table = ty.table();
    let mut writer = Writer { table, known: BTreeMap::new(), queue: Vec::new() };
    writer.name(ty.id());
    let mut out = String::new();
    let mut next = 0;
    while let Some((name, of)) = writer.queue.get(next).cloned() {
        if next > 0 {
            _ = writeln!(out, "{RULE}\nMSG: {}/{}", name.package, name.name);
        }
        out.push_str(&writer.definition(of)?);
        next += 1;
    }
    Some(out)
}

/// Name of the message that stands for a type of a table.
#[must_use]
pub fn name_in(table: &TypeTable, id: TypeId) -> MessageName {
    let standard = match table.resolved(id) {
        Kind::Boolean => "Bool",
        Kind::Char => "Int8",
        Kind::Octet => "UInt8",
        Kind::Short => "Int16",
        Kind::UnsignedShort => "UInt16",
        Kind::Long => "Int32",
        Kind::UnsignedLong => "UInt32",
        Kind::LongLong => "Int64",
        Kind::UnsignedLongLong => "UInt64",
        Kind::Float => "Float32",
        Kind::Double => "Float64",
        Kind::String { .. } => "String",
        // A struct keeps its own message name also when used through a typedef.
        Kind::Struct { name, .. } | Kind::Union { name, .. } | Kind::Exception { name, .. } => {
            return scoped(name);
        }
        _ => "",
    };
    if !standard.is_empty() {
        return MessageName { package: "std_msgs".to_owned(), name: standard.to_owned() };
    }
    match table.kind(id).name() {
        Some(name) => scoped(name),
        None => {
            let name = camel([table.c_name(id).as_str()]);
            MessageName { package: ANONYMOUS.to_owned(), name }
        }
    }
}

/// Package and name of a scoped name: `::or_pose::track::state` is `or_pose/msg/TrackState`.
#[must_use]
pub fn scoped(name: &ScopedName) -> MessageName {
    let (package, name) = match name.segments() {
        [] => (ANONYMOUS.to_owned(), "Unnamed".to_owned()),
        [alone] => (ANONYMOUS.to_owned(), camel([alone.as_str()])),
        [first, rest @ ..] => (package(first), camel(rest.iter().map(String::as_str))),
    };
    MessageName { package, name }
}

/// A legal package name: small letters, digits, single underscores.
#[must_use]
pub fn package(scope: &str) -> String {
    let legal = scope.starts_with(|c: char| c.is_ascii_lowercase())
        && scope.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !scope.ends_with('_')
        && !scope.contains("__");
    if legal { scope.to_owned() } else { format!("genom_{}", snake(scope)) }
}

/// Small letters, digits and single underscores: `maxSpeed` is `max_speed`.
#[must_use]
pub fn snake(name: &str) -> String {
    let mut out = String::new();
    let mut before = '_';
    for c in name.chars() {
        let begins = c.is_ascii_uppercase() && !before.is_ascii_uppercase();
        if (begins || c == '_') && !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
        if c != '_' {
            out.push(c.to_ascii_lowercase());
        }
        before = c;
    }
    out.truncate(out.trim_end_matches('_').len());
    out
}

/// `[track, arm_state]` is `TrackArmState`.
#[must_use]
pub fn camel<'a>(segments: impl IntoIterator<Item = &'a str>) -> String {
    let mut out = String::new();
    for word in segments.into_iter().flat_map(|s| s.split(|c: char| !c.is_ascii_alphanumeric())) {
        let mut letters = word.chars();
        out.extend(letters.next().map(|first| first.to_ascii_uppercase()));
        out.push_str(letters.as_str());
    }
    out
}

/// Writes definitions, and collects the messages they name.
struct Writer<'a> {
    table: &'a TypeTable,
    known: BTreeMap<MessageName, TypeId>,
    /// Messages still to be defined, in order of first mention.
    queue: Vec<(MessageName, TypeId)>,
}

/// Type of a field: its base name, and the brackets of an array or sequence.
struct Field {
    base: String,
    brackets: String,
}

impl Writer<'_> {
    /// The name of a message that the text defines.
    fn name(&mut self, id: TypeId) -> MessageName {
        let name = name_in(self.table, id);
        if !self.known.contains_key(&name) {
            self.known.insert(name.clone(), id);
            self.queue.push((name.clone(), id));
        }
        name
    }

    fn definition(&mut self, id: TypeId) -> Option<String> {
        let mut fields = Fields::default();
        match self.table.resolved(id) {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                for member in members {
                    self.constants(member.ty, &mut fields);
                    let field = self.field(member.ty)?;
                    fields.add(&field, &member.name);
                }
            }
            Kind::Union { discriminant, members, .. } => {
                self.constants(*discriminant, &mut fields);
                let field = self.field(*discriminant)?;
                fields.add(&field, "discriminant");
                for member in members {
                    let field = self.of_several(member.ty, "[<=1]")?;
                    fields.add(&field, &member.name);
                }
            }
            _ => {
                self.constants(id, &mut fields);
                let field = self.field(id)?;
                fields.add(&field, "data");
            }
        }
        Some(fields.text)
    }

    /// Writes the values of an enum as constants, before the field that uses it.
    fn constants(&self, id: TypeId, fields: &mut Fields) {
        if let Kind::Enum { enumerators, .. } = self.table.resolved(id) {
            for (value, name) in enumerators.iter().enumerate() {
                fields.constant(name, value);
            }
        }
    }

    fn field(&mut self, id: TypeId) -> Option<Field> {
        let base = match self.table.resolved(id) {
            Kind::Boolean => "bool".to_owned(),
            Kind::Char => "int8".to_owned(),
            Kind::Octet => "uint8".to_owned(),
            Kind::Short => "int16".to_owned(),
            Kind::UnsignedShort => "uint16".to_owned(),
            Kind::Long => "int32".to_owned(),
            Kind::UnsignedLong | Kind::Enum { .. } => "uint32".to_owned(),
            Kind::LongLong => "int64".to_owned(),
            Kind::UnsignedLongLong => "uint64".to_owned(),
            Kind::Float => "float32".to_owned(),
            Kind::Double => "float64".to_owned(),
            Kind::String { bound: None } => "string".to_owned(),
            // The IDL bound includes the NUL, that of ROS does not.
            Kind::String { bound: Some(bound) } => {
                format!("string<={}", bound.saturating_sub(1).max(1))
            }
            Kind::Struct { .. } | Kind::Union { .. } | Kind::Exception { .. } => {
                let MessageName { package, name } = self.name(id);
                format!("{package}/{name}")
            }
            Kind::Array { .. } => {
                // Dimensions are flattened, row by row: CDR writes the elements only.
                let (mut element, mut count) = (id, 1_u64);
                while let Kind::Array { element: inner, length } = self.table.resolved(element) {
                    (element, count) = (*inner, count.saturating_mul(u64::from(*length)));
                }
                return self.of_several(element, &format!("[{count}]"));
            }
            Kind::Sequence { element, bound: None } => return self.of_several(*element, "[]"),
            Kind::Sequence { element, bound: Some(bound) } => {
                return self.of_several(*element, &format!("[<={bound}]"));
            }
            Kind::Optional { element } => return self.of_several(*element, "[<=1]"),
            Kind::Native { .. } | Kind::Any | Kind::Forward { .. } | Kind::Typedef { .. } => {
                return None;
            }
        };
        Some(Field { base, brackets: String::new() })
    }

    /// An array or sequence of a type; elements that are arrays or sequences are wrapped in a
    /// message.
    fn of_several(&mut self, element: TypeId, brackets: &str) -> Option<Field> {
        let one = self.field(element)?;
        let base = if one.brackets.is_empty() {
            one.base
        } else {
            let MessageName { package, name } = self.name(element);
            format!("{package}/{name}")
        };
        Some(Field { base, brackets: brackets.to_owned() })
    }
}

/// The lines of a definition.
#[derive(Default)]
struct Fields {
    text: String,
    names: Vec<String>,
}

impl Fields {
    fn add(&mut self, field: &Field, name: &str) {
        let name = self.free(legal_field(name));
        _ = writeln!(self.text, "{}{} {name}", field.base, field.brackets);
        self.names.push(name);
    }

    fn constant(&mut self, name: &str, value: usize) {
        let name = legal_field(name).to_ascii_uppercase();
        if !self.names.contains(&name) {
            _ = writeln!(self.text, "uint32 {name}={value}");
            self.names.push(name);
        }
    }

    /// The name, with a number appended when it is taken: names that differ in IDL may become equal
    /// by ROS's rules.
    fn free(&self, name: String) -> String {
        let numbered = (2_u32..).map(|number| format!("{name}{number}"));
        let mut all = std::iter::once(name.clone()).chain(numbered);
        all.find(|name| !self.names.contains(name)).unwrap_or_default()
    }
}

/// A legal field name: small letters, digits, single underscores inside.
fn legal_field(name: &str) -> String {
    let words: Vec<String> =
        name.split('_').filter(|word| !word.is_empty()).map(str::to_ascii_lowercase).collect();
    let joined = words.join("_");
    if joined.starts_with(|c: char| c.is_ascii_lowercase()) { joined } else { format!("m{joined}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::kind::{Label, Member, UnionMember};

    fn member(name: &str, ty: TypeId) -> Member {
        Member { name: name.to_owned(), ty }
    }

    #[track_caller]
    fn check(table: TypeTable, id: TypeId, name: &str, text: &str) {
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        assert_eq!(message_name(&ty).to_string(), name);
        assert_eq!(message_definition(&ty).as_deref(), Some(text));
    }

    #[test]
    fn packages_are_legal() {
        for (scope, name) in [
            ("demo", "demo"),
            ("or_pose_estimator", "or_pose_estimator"),
            ("Demo", "genom_demo"),
            ("_x", "genom_x"),
            ("a__B_", "genom_a_b"),
        ] {
            assert_eq!(package(scope), name);
        }
    }

    #[test]
    fn a_basic_type_is_a_standard_message() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        check(table, id, "std_msgs/msg/Float64", "float64 data\n");
    }

    #[test]
    fn a_struct_defines_all_it_is_made_of() {
        let mut table = TypeTable::default();
        let double = table.add(Kind::Double);
        let row = table.add(Kind::Array { element: double, length: 3 });
        let matrix = table.add(Kind::Array { element: row, length: 2 });
        let name = table.add(Kind::String { bound: Some(8) });
        let path = table.add(Kind::Sequence { element: double, bound: None });
        let paths = table.add(Kind::Sequence { element: path, bound: Some(4) });
        let mode = table.add(Kind::Enum {
            name: ScopedName::new(["demo", "mode"]),
            enumerators: vec!["IDLE".into(), "Moving".into()],
        });
        let some = table.add(Kind::Union {
            name: ScopedName::new(["demo", "some"]),
            discriminant: mode,
            members: vec![UnionMember {
                name: "at".into(),
                ty: double,
                labels: vec![Label::Default],
            }],
        });
        let maybe = table.add(Kind::Optional { element: some });
        let members = vec![
            member("M_", matrix),
            member("m", name),
            member("paths", paths),
            member("maybe", maybe),
        ];
        let name = ScopedName::new(["demo", "arm", "state"]);
        let id = table.add(Kind::Struct { name, members });
        let rule = RULE;
        check(
            table,
            id,
            "demo/msg/ArmState",
            &format!(
                "float64[6] m\nstring<=7 m2\ngenom_types/SequenceDouble[<=4] paths\n\
                 demo/Some[<=1] maybe\n{rule}\nMSG: genom_types/SequenceDouble\nfloat64[] data\n\
                 {rule}\nMSG: demo/Some\nuint32 IDLE=0\nuint32 MOVING=1\nuint32 discriminant\n\
                 float64[<=1] at\n"
            ),
        );
    }

    #[test]
    fn a_native_has_no_message() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Native { name: ScopedName::new(["demo", "handle"]) });
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        assert_eq!(message_definition(&ty), None);
    }
}
