//! Comparing types (genom3.md 4.3).

use std::collections::HashSet;

use crate::digest::Digester;
use crate::kind::{Kind, TypeId};
use crate::layout::MAX_NESTING;
use crate::table::TypeTable;

impl TypeTable {
    /// Whether two types are the same by structure: names of structs and of members do not
    /// count, those of enums, natives and uncompleted forwards do (genom3.md 4.3).
    #[must_use]
    pub fn equal(&self, a: TypeId, b: TypeId) -> bool {
        self.equal_to(a, self, b)
    }

    /// [`equal`](TypeTable::equal) for a type `b` of another table.
    #[must_use]
    pub fn equal_to(&self, a: TypeId, other: &TypeTable, b: TypeId) -> bool {
        // Pairs already assumed equal, so that recursive types terminate. An explicit work list
        // replaces recursion: deep nesting costs no stack.
        let mut seen = HashSet::new();
        let mut todo = vec![(a, b)];
        while let Some((a, b)) = todo.pop() {
            let (a, b) = (self.resolve(a), other.resolve(b));
            if (std::ptr::eq(self, other) && a == b) || !seen.insert((a, b)) {
                continue;
            }
            match (self.kind(a), other.kind(b)) {
                (Kind::String { bound: a }, Kind::String { bound: b }) if a == b => {}
                (Kind::Array { element: a, length: m }, Kind::Array { element: b, length: n })
                    if m == n =>
                {
                    todo.push((*a, *b))
                }
                (
                    Kind::Sequence { element: a, bound: m },
                    Kind::Sequence { element: b, bound: n },
                ) if m == n => todo.push((*a, *b)),
                (Kind::Optional { element: a }, Kind::Optional { element: b }) => {
                    todo.push((*a, *b));
                }
                (Kind::Struct { members: a, .. }, Kind::Struct { members: b, .. })
                | (Kind::Exception { members: a, .. }, Kind::Exception { members: b, .. })
                    if a.len() == b.len() =>
                {
                    todo.extend(a.iter().map(|m| m.ty).zip(b.iter().map(|m| m.ty)));
                }
                (
                    Kind::Union { members: a, discriminant: d, .. },
                    Kind::Union { members: b, discriminant: e, .. },
                ) if a.len() == b.len() => {
                    // genom3.md 4.3 does not mention labels, but values of unions with different
                    // labels cannot be copied into each other.
                    if a.iter().zip(b).any(|(a, b)| a.labels != b.labels) {
                        return false;
                    }
                    todo.push((*d, *e));
                    todo.extend(a.iter().map(|m| m.ty).zip(b.iter().map(|m| m.ty)));
                }
                (
                    Kind::Enum { name: a, enumerators: m },
                    Kind::Enum { name: b, enumerators: n },
                ) if a == b && m == n => {}
                (Kind::Native { name: a }, Kind::Native { name: b }) if a == b => {}
                (Kind::Forward { name: a, .. }, Kind::Forward { name: b, .. }) if a == b => {}
                (a, b) if is_basic(a) && a == b => {}
                _ => return false,
            }
        }
        true
    }

    /// Whether the type has no unbounded string or sequence and no native anywhere inside
    /// (genom3.md 4.3, "fixed size").
    #[must_use]
    pub fn is_fixed_size(&self, id: TypeId) -> bool {
        let mut seen = HashSet::new();
        let mut todo = vec![id];
        while let Some(id) = todo.pop() {
            let id = self.resolve(id);
            if !seen.insert(id) {
                continue;
            }
            match self.kind(id) {
                Kind::String { bound: None }
                | Kind::Sequence { bound: None, .. }
                | Kind::Native { .. } => return false,
                Kind::Array { element, .. }
                | Kind::Sequence { element, .. }
                | Kind::Optional { element } => todo.push(*element),
                Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                    todo.extend(members.iter().map(|m| m.ty));
                }
                Kind::Union { members, .. } => todo.extend(members.iter().map(|m| m.ty)),
                _ => {}
            }
        }
        true
    }
}

/// A digest that two types share exactly when [`TypeTable::equal_to`] holds; `None` for recursive
/// types and those with too many members, which have to be compared.
pub(crate) fn fingerprint(table: &TypeTable, id: TypeId) -> Option<String> {
    let mut digester = Digester::default();
    let mut left = 100_000;
    print(table, id, &mut Vec::new(), &mut left, &mut digester)?;
    Some(digester.finish())
}

fn print(
    table: &TypeTable,
    id: TypeId,
    open: &mut Vec<TypeId>,
    left: &mut u32,
    out: &mut Digester,
) -> Option<()> {
    let id = table.resolve(id);
    *left = left.checked_sub(1)?;
    if open.len() > MAX_NESTING || open.contains(&id) {
        return None;
    }
    open.push(id);
    let kind = table.kind(id);
    out.text(kind.keyword());
    match kind {
        Kind::String { bound } => _ = out.text(&format!("{bound:?}")),
        Kind::Array { element, length } => {
            out.text(&length.to_string());
            print(table, *element, open, left, out)?;
        }
        Kind::Sequence { element, bound } => {
            out.text(&format!("{bound:?}"));
            print(table, *element, open, left, out)?;
        }
        Kind::Optional { element } => print(table, *element, open, left, out)?,
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
            out.text(&members.len().to_string());
            for member in members {
                print(table, member.ty, open, left, out)?;
            }
        }
        Kind::Union { members, discriminant, .. } => {
            out.text(&members.len().to_string());
            print(table, *discriminant, open, left, out)?;
            for member in members {
                out.text(&format!("{:?}", member.labels));
                print(table, member.ty, open, left, out)?;
            }
        }
        Kind::Enum { name, enumerators } => _ = out.text(&format!("{name} {enumerators:?}")),
        kind => {
            if let Some(name) = kind.name() {
                out.text(&name.to_string());
            }
        }
    }
    open.pop();
    Some(())
}

/// Whether the kind alone identifies the type: it has no name and no element type.
fn is_basic(kind: &Kind) -> bool {
    matches!(
        kind,
        Kind::Boolean
            | Kind::Char
            | Kind::Octet
            | Kind::Short
            | Kind::UnsignedShort
            | Kind::Long
            | Kind::UnsignedLong
            | Kind::LongLong
            | Kind::UnsignedLongLong
            | Kind::Float
            | Kind::Double
            | Kind::Any
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::{Member, ScopedName};

    fn named(table: &mut TypeTable, name: &str, members: &[(&str, TypeId)]) -> TypeId {
        let members = members.iter().map(|&(n, ty)| Member { name: n.to_owned(), ty }).collect();
        table.add(Kind::Struct { name: ScopedName::new([name]), members })
    }

    #[test]
    fn structs_are_compared_by_structure_and_enums_by_name() {
        let mut t = TypeTable::default();
        let long = t.add(Kind::Long);
        let short = t.add(Kind::Short);
        let a = named(&mut t, "a", &[("x", long), ("y", short)]);
        let b = named(&mut t, "b", &[("u", long), ("v", short)]);
        let c = named(&mut t, "c", &[("x", short), ("y", long)]);
        assert!(t.equal(a, b));
        assert!(!t.equal(a, c));
        let mut color = |name| {
            let enumerators = vec!["RED".to_owned()];
            t.add(Kind::Enum { name: ScopedName::new([name]), enumerators })
        };
        let (d, e, f) = (color("m"), color("n"), color("m"));
        assert!(!t.equal(d, e));
        assert!(t.equal(d, f));
    }

    #[test]
    fn recursive_types_are_compared_without_end() {
        let mut t = TypeTable::default();
        let mut tree = |name: &str| {
            let fwd = t.add(Kind::Forward { name: ScopedName::new([name]), union: false });
            let ty = t.add(Kind::Sequence { element: fwd, bound: None });
            let members = vec![Member { name: "kids".to_owned(), ty }];
            t.complete(fwd, Kind::Struct { name: ScopedName::new([name]), members });
            fwd
        };
        let (a, b) = (tree("a"), tree("b"));
        assert!(t.equal(a, b));
        assert!(!t.is_fixed_size(a));
    }
}
