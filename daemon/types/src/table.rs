//! The types of one specification, by index.

use crate::kind::{Kind, TypeId};

/// An append-only table of types. Basic types and anonymous templates are shared.
///
/// Named types are unique by construction: the `.gen` reader inserts each declaration once.
#[derive(Clone, Debug, Default)]
pub struct TypeTable {
    kinds: Vec<Kind>,
}

impl TypeTable {
    /// Adds a type and returns its index.
    pub fn add(&mut self, kind: Kind) -> TypeId {
        let id = TypeId(u32::try_from(self.kinds.len()).unwrap_or(u32::MAX));
        self.kinds.push(kind);
        id
    }

    /// Completes a forward declaration in place: ids already handed out now mean `kind`.
    pub fn complete(&mut self, id: TypeId, kind: Kind) {
        if let Some(slot) = self.kinds.get_mut(id.index()) {
            *slot = kind;
        }
    }

    /// What the type is, typedefs not followed.
    #[must_use]
    pub fn kind(&self, id: TypeId) -> &Kind {
        &self.kinds[id.index()]
    }

    /// The type behind any chain of typedefs.
    #[must_use]
    pub fn resolve(&self, mut id: TypeId) -> TypeId {
        while let Kind::Typedef { target, .. } = self.kind(id) {
            id = *target;
        }
        id
    }

    /// The kind behind any chain of typedefs.
    #[must_use]
    pub fn resolved(&self, id: TypeId) -> &Kind {
        self.kind(self.resolve(id))
    }

    /// Every type with its index, in order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (TypeId, &Kind)> {
        (0u32..).map(TypeId).zip(&self.kinds)
    }
}
