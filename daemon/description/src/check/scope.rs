//! Scopes, and what names refer to in them (genom3.md 4.2).

use std::collections::HashMap;
use std::rc::Rc;

use genom_types::{ScopedName, TypeId};

use crate::model::Span;
use crate::syntax::{Name, Path};

/// Index of a scope; 0 is the root.
pub(super) type ScopeId = usize;

/// What a name refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entity {
    Type(TypeId),
    /// Index among the constants.
    Const(usize),
    /// Its enum, and its index there.
    Enumerator(TypeId, u32),
    /// Member of a struct, union or exception: occupies the name, but look-ups ignore it.
    Member,
    Port,
    Remote,
    State,
}

/// Kind of a new declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    Type,
    Member,
    State,
    Other,
}

impl Sort {
    pub(super) fn of(entity: Entity) -> Self {
        match entity {
            Entity::Type(_) => Sort::Type,
            Entity::Member => Sort::Member,
            Entity::State => Sort::State,
            _ => Sort::Other,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScopeKind {
    /// Root, module, component, interface.
    Module,
    /// Struct, union, exception, IDS.
    Record,
}

#[derive(Debug)]
pub(super) struct Scope {
    parent: Option<ScopeId>,
    name: Rc<str>,
    kind: ScopeKind,
    names: HashMap<Rc<str>, (Entity, Span)>,
    children: HashMap<Rc<str>, ScopeId>,
    span: Span,
}

#[derive(Debug)]
pub(super) struct Scopes {
    all: Vec<Scope>,
}

impl Scopes {
    pub(super) fn new() -> Self {
        let mut scopes = Scopes { all: Vec::new() };
        scopes.add(None, "", ScopeKind::Module, Span::default());
        scopes
    }

    /// Drops the declarations in all scopes, to save memory; the names of the scopes remain.
    pub(super) fn forget_names(&mut self) {
        for scope in &mut self.all {
            scope.names = HashMap::new();
            scope.children = HashMap::new();
        }
    }

    /// Adds a scope that cannot be found by name yet.
    pub(super) fn add(
        &mut self,
        parent: Option<ScopeId>,
        name: &str,
        kind: ScopeKind,
        span: Span,
    ) -> ScopeId {
        let (names, children) = (HashMap::new(), HashMap::new());
        self.all.push(Scope { parent, name: name.into(), kind, names, children, span });
        self.all.len() - 1
    }

    /// A child scope that can be named.
    pub(super) fn add_child(&mut self, parent: ScopeId, name: &Name, kind: ScopeKind) -> ScopeId {
        let id = self.add(Some(parent), &name.text, kind, name.span);
        self.all[parent].children.insert(name.text.clone(), id);
        id
    }

    pub(super) fn child(&self, id: ScopeId, name: &str) -> Option<(ScopeId, ScopeKind, Span)> {
        let child = *self.all[id].children.get(name)?;
        Some((child, self.all[child].kind, self.all[child].span))
    }

    pub(super) fn local(&self, id: ScopeId, name: &str) -> Option<(Entity, Span)> {
        self.all[id].names.get(name).copied()
    }

    pub(super) fn set(&mut self, id: ScopeId, name: &str, entity: Entity, span: Span) {
        self.all[id].names.insert(name.into(), (entity, span));
    }

    pub(super) fn kind(&self, id: ScopeId) -> ScopeKind {
        self.all[id].kind
    }

    pub(super) fn span(&self, id: ScopeId) -> Span {
        self.all[id].span
    }

    /// The name of the scope itself, unless it is the root.
    pub(super) fn own_name(&self, id: ScopeId) -> Option<&str> {
        let scope = &self.all[id];
        scope.parent.map(|_| &*scope.name)
    }

    pub(super) fn full_name(&self, id: ScopeId) -> ScopedName {
        let mut segments = Vec::new();
        let mut at = id;
        while let Some(parent) = self.all[at].parent {
            segments.push(self.all[at].name.to_string());
            at = parent;
        }
        segments.reverse();
        ScopedName::new(segments)
    }

    fn find_from(&self, mut scope: ScopeId, segments: &[Name]) -> Option<(Entity, Span)> {
        let (last, outer) = segments.split_last()?;
        for segment in outer {
            scope = *self.all[scope].children.get(&segment.text)?;
        }
        self.local(scope, &last.text).filter(|(entity, _)| *entity != Entity::Member)
    }

    /// Resolves a path: each scope from the inside out, the path tried as a whole.
    // genom3.md 4.2.
    pub(super) fn find(&self, from: ScopeId, path: &Path) -> Option<(Entity, Span)> {
        if path.absolute {
            return self.find_from(0, &path.segments);
        }
        let mut at = Some(from);
        while let Some(scope) = at {
            if let Some(found) = self.find_from(scope, &path.segments) {
                return Some(found);
            }
            at = self.all[scope].parent;
        }
        None
    }

    /// Names that `path` may have been meant to be, for suggestions.
    pub(super) fn candidates(&self, from: ScopeId, path: &Path) -> Vec<&str> {
        let mut names = Vec::new();
        let mut at = Some(from);
        while let Some(scope) = at {
            let mut inner = Some(scope);
            for segment in &path.segments[..path.segments.len().saturating_sub(1)] {
                inner = inner.and_then(|id| self.all[id].children.get(&segment.text).copied());
            }
            if let Some(id) = inner {
                let known = self.all[id].names.iter();
                names.extend(
                    known
                        .filter(|(_, (entity, _))| {
                            matches!(
                                entity,
                                Entity::Type(_) | Entity::Const(_) | Entity::Enumerator(..)
                            )
                        })
                        .map(|(name, _)| &**name),
                );
            }
            at = self.all[scope].parent;
        }
        names.sort_unstable();
        names
    }
}
