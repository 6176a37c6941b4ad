//! Digests of types and of what is made of them (genom3.md 4.9).
//!
//! A digest is the MD5 of a list of strings, each followed by `|`. It detects types that differ by
//! mistake; it is no protection against deliberate collisions.

use std::fmt::Write as _;

use md5::{Digest as _, Md5};

use crate::kind::{Kind, TypeId};
use crate::table::TypeTable;

/// Most types visited for one digest. Structs that double at each level of nesting would otherwise
/// take exponential time; beyond the limit, types contribute only the names of their kinds.
const MOST: u32 = 1 << 18;

/// Deepest nesting of types that is followed.
const DEEPEST: usize = 256;

/// A digest being computed.
///
/// ```
/// # use genom_types::{Digester, Kind, TypeTable};
/// let mut table = TypeTable::default();
/// let long = table.add(Kind::Long);
/// let mut digester = Digester::default();
/// digester.text("in").ty(&table, long);
/// assert_eq!(digester.finish(), genom_types::digest_of(["in", "long"]));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Digester {
    md5: Md5,
}

impl Digester {
    /// Adds a string.
    pub fn text(&mut self, part: &str) -> &mut Self {
        self.md5.update(part);
        self.md5.update("|");
        self
    }

    /// Adds the strings of a type.
    pub fn ty(&mut self, table: &TypeTable, id: TypeId) -> &mut Self {
        Walk { table, left: MOST, open: Vec::new() }.add(id, self);
        self
    }

    /// The digest: hexadecimal, each byte without padding.
    #[must_use]
    pub fn finish(self) -> String {
        let mut out = String::with_capacity(32);
        for byte in self.md5.finalize() {
            _ = write!(out, "{byte:x}");
        }
        out
    }
}

/// The digest of a list of strings.
pub fn digest_of<S: AsRef<str>>(parts: impl IntoIterator<Item = S>) -> String {
    let mut digester = Digester::default();
    for part in parts {
        digester.text(part.as_ref());
    }
    digester.finish()
}

impl TypeTable {
    /// The digest of a type (genom3.md 4.9). Names of members count, the type's own does not.
    #[must_use]
    pub fn digest(&self, id: TypeId) -> String {
        let mut digester = Digester::default();
        digester.ty(self, id);
        digester.finish()
    }
}

struct Walk<'a> {
    table: &'a TypeTable,
    /// Types that may still be visited.
    left: u32,
    /// Types being expanded: a recursive use of one contributes only the name of its kind.
    open: Vec<TypeId>,
}

impl Walk<'_> {
    fn add(&mut self, id: TypeId, out: &mut Digester) {
        let id = self.table.resolve(id);
        let kind = self.table.kind(id);
        self.left = self.left.saturating_sub(1);
        if self.left == 0 || self.open.len() >= DEEPEST || self.open.contains(&id) {
            out.text(kind.keyword());
            return;
        }
        self.open.push(id);
        match kind {
            Kind::String { bound } => {
                out.text("string");
                if let Some(bound) = bound {
                    out.text(&bound.to_string());
                }
            }
            Kind::Array { element, length } => {
                out.text("array").text(&length.to_string());
                self.add(*element, out);
            }
            Kind::Sequence { element, bound } => {
                out.text("sequence");
                if let Some(bound) = bound {
                    out.text(&bound.to_string());
                }
                self.add(*element, out);
            }
            Kind::Optional { element } => {
                out.text("optional");
                self.add(*element, out);
            }
            Kind::Enum { enumerators, .. } => {
                for name in enumerators {
                    out.text(name).text("enumerator");
                }
            }
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                for member in members {
                    out.text(&member.name);
                    self.add(member.ty, out);
                }
            }
            Kind::Union { members, .. } => {
                for member in members {
                    out.text(&member.name).text("union member");
                }
            }
            kind => _ = out.text(kind.keyword()),
        }
        self.open.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::{Member, ScopedName};

    #[test]
    fn the_worked_example_has_its_digests() {
        // genom3.md 4.9: service f and component c.
        let mut t = TypeTable::default();
        let long = t.add(Kind::Long);
        let short = t.add(Kind::Short);
        let double = t.add(Kind::Double);
        let text = t.add(Kind::String { bound: Some(8) });
        let pair = t.add(Kind::Array { element: double, length: 2 });
        let list = t.add(Kind::Sequence { element: long, bound: None });
        let member = |name: &str, ty| Member { name: name.to_owned(), ty };
        let s = t.add(Kind::Struct {
            name: ScopedName::new(["c", "s"]),
            members: vec![
                member("a", long),
                member("b", text),
                member("c", pair),
                member("d", list),
            ],
        });
        let e = t.add(Kind::Exception {
            name: ScopedName::new(["c", "e"]),
            members: vec![member("q", short)],
        });

        let mut service = Digester::default();
        service.text("in").ty(&t, long).text("out").ty(&t, s).ty(&t, e);
        assert_eq!(service.clone().finish(), "384aad12927a41b9b5279c6a0474efa");

        let mut component = Digester::default();
        component.text("port").text("simple").text("p").ty(&t, s);
        component.text("function").text("f");
        component.text("in").ty(&t, long).text("out").ty(&t, s).ty(&t, e);
        assert_eq!(component.finish(), "1fb4d66bbb8ad1586d8de865f40ae90");
    }

    #[test]
    fn structs_that_double_at_each_level_end() {
        let mut t = TypeTable::default();
        let mut ty = t.add(Kind::Long);
        for level in 0..200 {
            let name = ScopedName::new([format!("s{level}")]);
            let members = ["a", "b"].map(|name| Member { name: name.to_owned(), ty }).into();
            ty = t.add(Kind::Struct { name, members });
        }
        assert!(!t.digest(ty).is_empty());
    }
}
