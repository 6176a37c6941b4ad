//! How a type is spelled, in IDL and in C (genom3.md 5.1, 5.2).

use std::fmt::Write as _;

use crate::kind::{Kind, TypeId};
use crate::table::TypeTable;

/// Deepest nesting of anonymous templates that is spelled out; deeper ones end in `...`.
const DEEPEST: usize = 128;

impl TypeTable {
    /// The IDL spelling: `unsigned long`, `sequence<long,4>`, `double[2][3]`, `::demo::state`.
    #[must_use]
    pub fn spelling(&self, id: TypeId) -> String {
        let mut out = String::new();
        self.spell(id, DEEPEST, &mut out);
        out
    }

    fn spell(&self, id: TypeId, depth: usize, out: &mut String) {
        if depth == 0 {
            out.push_str("...");
            return;
        }
        match self.kind(id) {
            Kind::String { bound: Some(bound) } => _ = write!(out, "string<{bound}>"),
            Kind::Sequence { element, bound } => {
                out.push_str("sequence<");
                self.spell(*element, depth - 1, out);
                if let Some(bound) = bound {
                    _ = write!(out, ",{bound}");
                }
                out.push('>');
            }
            Kind::Optional { element } => {
                out.push_str("optional<");
                self.spell(*element, depth - 1, out);
                out.push('>');
            }
            Kind::Array { .. } => {
                let (element, dimensions) = self.dimensions(id);
                self.spell(element, depth - 1, out);
                out.push_str(&dimensions);
            }
            kind => match kind.name() {
                Some(name) => _ = write!(out, "{name}"),
                None => out.push_str(kind.keyword()),
            },
        }
    }

    /// The C type of a datum: `uint32_t`, `char *`, `double[2][3]`, `sequence4_long`,
    /// `demo_state`. For an array the dimensions come last, as in a cast.
    #[must_use]
    pub fn c_name(&self, id: TypeId) -> String {
        match self.kind(id) {
            Kind::Array { .. } => {
                let (element, dimensions) = self.dimensions(id);
                self.c_name(element) + &dimensions
            }
            Kind::String { bound: None } => "char *".to_owned(),
            Kind::String { bound: Some(bound) } => format!("char[{bound}]"),
            Kind::Native { name } => format!("{} *", name.to_c()),
            Kind::Exception { name, .. } => format!("{}_detail", name.to_c()),
            Kind::Boolean => "bool".to_owned(),
            Kind::Char => "int8_t".to_owned(),
            Kind::Octet => "uint8_t".to_owned(),
            Kind::Short => "int16_t".to_owned(),
            Kind::UnsignedShort => "uint16_t".to_owned(),
            Kind::Long => "int32_t".to_owned(),
            Kind::UnsignedLong => "uint32_t".to_owned(),
            Kind::LongLong => "int64_t".to_owned(),
            Kind::UnsignedLongLong => "uint64_t".to_owned(),
            _ => {
                let mut out = String::new();
                self.tag(id, DEEPEST, &mut out);
                out
            }
        }
    }

    /// Tag of the C struct of an anonymous template (genom3.md 5.2): kind, bound, element.
    fn tag(&self, id: TypeId, depth: usize, out: &mut String) {
        if depth == 0 {
            return;
        }
        match self.kind(id) {
            Kind::String { bound: Some(bound) } => _ = write!(out, "string{bound}"),
            Kind::Sequence { element, bound } => {
                out.push_str("sequence");
                if let Some(bound) = bound {
                    _ = write!(out, "{bound}");
                }
                out.push('_');
                self.tag(*element, depth - 1, out);
            }
            Kind::Optional { element } => {
                out.push_str("optional_");
                self.tag(*element, depth - 1, out);
            }
            kind => match kind.name() {
                Some(name) => out.push_str(&name.to_c()),
                None => out.push_str(&kind.keyword().replace(' ', "_")),
            },
        }
    }

    /// The innermost element of an array and its dimensions, outermost first.
    fn dimensions(&self, mut id: TypeId) -> (TypeId, String) {
        let mut dimensions = String::new();
        while let Kind::Array { element, length } = self.kind(id) {
            _ = write!(dimensions, "[{length}]");
            id = *element;
        }
        (id, dimensions)
    }
}

impl Kind {
    /// The IDL keyword of a kind: the whole spelling of a basic type.
    #[must_use]
    pub fn keyword(&self) -> &'static str {
        match self {
            Kind::Boolean => "boolean",
            Kind::Char => "char",
            Kind::Octet => "octet",
            Kind::Short => "short",
            Kind::UnsignedShort => "unsigned short",
            Kind::Long => "long",
            Kind::UnsignedLong => "unsigned long",
            Kind::LongLong => "long long",
            Kind::UnsignedLongLong => "unsigned long long",
            Kind::Float => "float",
            Kind::Double => "double",
            Kind::String { .. } => "string",
            Kind::Array { .. } => "array",
            Kind::Sequence { .. } => "sequence",
            Kind::Optional { .. } => "optional",
            Kind::Enum { .. } => "enum",
            Kind::Struct { .. } => "struct",
            Kind::Union { .. } => "union",
            Kind::Exception { .. } => "exception",
            Kind::Typedef { .. } => "typedef",
            Kind::Forward { union: false, .. } => "forward struct",
            Kind::Forward { union: true, .. } => "forward union",
            Kind::Native { .. } => "native",
            Kind::Any => "any",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::ScopedName;

    #[test]
    fn names_are_those_of_the_reference() {
        // genom3.md 5.2, "Struct tags of anonymous templates".
        let mut table = TypeTable::default();
        let long = table.add(Kind::Long);
        let ulong = table.add(Kind::UnsignedLong);
        let string4 = table.add(Kind::String { bound: Some(4) });
        let name = ScopedName::new(["m", "t"]);
        let named = table.add(Kind::Typedef { name, target: long });
        let inner = table.add(Kind::Sequence { element: long, bound: Some(4) });
        let optional = table.add(Kind::Optional { element: long });
        let row = table.add(Kind::Array { element: long, length: 3 });
        let cases = [
            (
                Kind::Sequence { element: ulong, bound: None },
                "sequence_unsigned_long",
                "sequence<unsigned long>",
            ),
            (
                Kind::Sequence { element: string4, bound: Some(2) },
                "sequence2_string4",
                "sequence<string<4>,2>",
            ),
            (
                Kind::Sequence { element: optional, bound: None },
                "sequence_optional_long",
                "sequence<optional<long>>",
            ),
            (
                Kind::Sequence { element: inner, bound: Some(2) },
                "sequence2_sequence4_long",
                "sequence<sequence<long,4>,2>",
            ),
            (Kind::Sequence { element: named, bound: None }, "sequence_m_t", "sequence<::m::t>"),
            (Kind::Array { element: row, length: 2 }, "int32_t[2][3]", "long[2][3]"),
            (Kind::String { bound: None }, "char *", "string"),
        ];
        for (kind, c, idl) in cases {
            let id = table.add(kind);
            assert_eq!(table.c_name(id), c);
            assert_eq!(table.spelling(id), idl);
        }
    }
}
