//! The types of one specification, by index.

use std::collections::HashMap;

use crate::kind::{Kind, Member, TypeId};

/// An append-only table of types. Basic types and anonymous templates are shared.
///
/// Named types are unique by construction: the `.gen` reader inserts each declaration once.
#[derive(Clone, Debug, Default)]
pub struct TypeTable {
    kinds: Vec<Kind>,
    /// Basic types and anonymous templates already there: `sequence<long>` has one id however
    /// often it is written.
    shared: HashMap<Kind, TypeId>,
}

impl TypeTable {
    /// The table of these types, in this order.
    pub(crate) fn of(kinds: Vec<Kind>) -> Self {
        Self { kinds, shared: HashMap::new() }
    }

    /// Adds a type and returns its index; a type without a name that is already there is reused.
    pub fn add(&mut self, kind: Kind) -> TypeId {
        let named = kind.name().is_some();
        if !named && let Some(&id) = self.shared.get(&kind) {
            return id;
        }
        let id = TypeId(u32::try_from(self.kinds.len()).unwrap_or(u32::MAX));
        if !named {
            self.shared.insert(kind.clone(), id);
        }
        self.kinds.push(kind);
        id
    }

    /// Completes a forward declaration in place: ids that were already handed out now refer to
    /// `kind`.
    pub fn complete(&mut self, id: TypeId, kind: Kind) {
        if let Some(slot) = self.kinds.get_mut(id.index()) {
            *slot = kind;
        }
    }

    /// Adds a member to a struct that may still grow (the IDS of a component being read).
    pub fn add_member(&mut self, id: TypeId, member: Member) {
        if let Some(Kind::Struct { members, .. }) = self.kinds.get_mut(id.index()) {
            members.push(member);
        }
    }

    /// Kind of the type; a typedef is not resolved.
    ///
    /// `id` comes from this table or from one it was cloned from.
    #[must_use]
    pub fn kind(&self, id: TypeId) -> &Kind {
        &self.kinds[id.index()]
    }

    /// The type behind any chain of typedefs.
    #[must_use]
    pub fn resolve(&self, mut id: TypeId) -> TypeId {
        // Bounded, so that a typedef completed into itself cannot hang the caller.
        for _ in 0..self.kinds.len() {
            match self.kind(id) {
                Kind::Typedef { target, .. } => id = *target,
                _ => break,
            }
        }
        id
    }

    /// The kind behind any chain of typedefs.
    #[must_use]
    pub fn resolved(&self, id: TypeId) -> &Kind {
        self.kind(self.resolve(id))
    }

    /// Members of the struct or exception behind any typedefs; empty for other types.
    #[must_use]
    pub fn members(&self, id: TypeId) -> &[Member] {
        match self.resolved(id) {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => members,
            _ => &[],
        }
    }

    /// Every type with its index, in order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (TypeId, &Kind)> {
        (0u32..).map(TypeId).zip(&self.kinds)
    }

    /// Number of types.
    #[must_use]
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Whether the table holds no type.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::ScopedName;

    #[test]
    fn anonymous_types_are_shared_and_named_ones_are_not() {
        let mut table = TypeTable::default();
        let long = table.add(Kind::Long);
        assert_eq!(table.add(Kind::Long), long);
        let some = table.add(Kind::Sequence { element: long, bound: Some(4) });
        assert_eq!(table.add(Kind::Sequence { element: long, bound: Some(4) }), some);
        assert_ne!(table.add(Kind::Sequence { element: long, bound: None }), some);
        let name = ScopedName::new(["t"]);
        let first = table.add(Kind::Typedef { name: name.clone(), target: long });
        assert_ne!(table.add(Kind::Typedef { name, target: long }), first);
        assert_eq!(table.resolve(first), long);
    }
}
