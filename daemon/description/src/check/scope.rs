//! Scopes and what names mean in them (genom3.md 4.2).

use std::collections::HashMap;
use std::rc::Rc;

use genom_types::{ScopedName, TypeId};

use super::Checker;
use super::room;
use crate::diagnostic::Diagnostic;
use crate::model::Span;
use crate::syntax::{Name, Path};

/// Rank of a scope; 0 is the root.
pub(super) type ScopeId = usize;

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Entity {
    Type(TypeId),
    /// Rank among the constants.
    Const(usize),
    /// Its enum and rank in it.
    Enumerator(TypeId, u32),
    /// Of a struct, union or exception: takes a name, is found by no look-up.
    Member,
    Port,
    Remote,
    State,
}

/// What is about to be declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    Type,
    Member,
    State,
    Other,
}

impl Sort {
    fn of(entity: Entity) -> Self {
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

    /// Lets go of what is declared where: only the names of the scopes remain.
    pub(super) fn forget_names(&mut self) {
        for scope in &mut self.all {
            scope.names = HashMap::new();
            scope.children = HashMap::new();
        }
    }

    /// A new scope, not yet reachable by name.
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

    /// The name of the scope itself, unless it is the root.
    fn own_name(&self, id: ScopeId) -> Option<&str> {
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

    /// Look-up: each scope outwards, the name tried as a whole.
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

    /// Names that `path` could have been meant to be.
    fn candidates(&self, from: ScopeId, path: &Path) -> Vec<&str> {
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

impl Checker {
    /// Gives `name` a meaning in the current scope; says why not otherwise.
    // genom3.md 3.2 N1, N2, N4, N13.
    pub(super) fn declare(&mut self, name: &Name, entity: Entity) -> bool {
        self.declare_in(self.scope, name, entity, "E0201")
    }

    pub(super) fn declare_in(
        &mut self,
        scope: ScopeId,
        name: &Name,
        entity: Entity,
        clash: &'static str,
    ) -> bool {
        let free = self.is_free(scope, name, Sort::of(entity), clash);
        if free {
            self.scopes.set(scope, &name.text, entity, name.span);
        }
        free
    }

    /// Whether `name` may be declared in a scope; says why not.
    pub(super) fn is_free(
        &mut self,
        scope: ScopeId,
        name: &Name,
        sort: Sort,
        clash: &'static str,
    ) -> bool {
        let text = &*name.text;
        if let Some((other, span)) = self.scopes.local(scope, text) {
            let what = self.describe(other);
            let message = format!("`{text}` is already the name of {what}");
            self.push(Diagnostic::error(clash, name.span, message).note(span, "declared here"));
            return false;
        }
        let module = self.scopes.all[scope].kind == ScopeKind::Module;
        if module && sort != Sort::Member && self.scopes.own_name(scope) == Some(text) {
            let message = format!("`{text}` is already the name of what encloses it");
            let span = self.scopes.all[scope].span;
            self.push(Diagnostic::error("E0202", name.span, message).note(span, "declared here"));
            return false;
        }
        // Every component has a module `pause`; a state of that name clashes with nothing.
        if sort != Sort::Member
            && !(sort == Sort::State && text == "pause")
            && let Some((_, ScopeKind::Module, span)) = self.scopes.child(scope, text)
        {
            let message = format!("`{text}` is already the name of a module or component");
            self.push(Diagnostic::error("E0204", name.span, message).note(span, "declared here"));
            return false;
        }
        true
    }

    /// Enters a module, made if need be.
    pub(super) fn open_module(&mut self, name: &Name) -> Option<ScopeId> {
        if self.scopes.own_name(self.scope) == Some(&*name.text) {
            let span = self.scopes.all[self.scope].span;
            let message = format!("`{}` is already the name of what encloses it", name.text);
            self.push(Diagnostic::error("E0203", name.span, message).note(span, "declared here"));
            return None;
        }
        match self.scopes.child(self.scope, &name.text) {
            Some((id, ScopeKind::Module, _)) => return Some(id),
            Some((_, ScopeKind::Record, span)) => {
                self.clash_with_type(name, span);
                return None;
            }
            None => {}
        }
        if let Some((_, span)) = self.scopes.local(self.scope, &name.text) {
            self.clash_with_type(name, span);
            return None;
        }
        self.reserve(room::SCOPE, name.span);
        Some(self.scopes.add_child(self.scope, name, ScopeKind::Module))
    }

    /// A scope for a struct, union or exception; not reachable by name if the name is refused.
    pub(super) fn open_record(&mut self, name: &Name) -> (ScopeId, bool) {
        self.reserve(room::SCOPE, name.span);
        let own = self.scopes.own_name(self.scope) == Some(&*name.text);
        if own {
            let span = self.scopes.all[self.scope].span;
            let message = format!("`{}` is already the name of what encloses it", name.text);
            self.push(Diagnostic::error("E0203", name.span, message).note(span, "declared here"));
        }
        if own || self.scopes.child(self.scope, &name.text).is_some() {
            let id = self.scopes.add(Some(self.scope), &name.text, ScopeKind::Record, name.span);
            return (id, !own);
        }
        (self.scopes.add_child(self.scope, name, ScopeKind::Record), true)
    }

    // genom3.md 3.2 N5.
    pub(super) fn clash_with_type(&mut self, name: &Name, other: Span) {
        let message = format!("`{}` is already declared", name.text);
        self.push(Diagnostic::error("E0205", name.span, message).note(other, "declared here"));
    }

    /// The meaning of a path; an unknown one is reported, and `None`.
    // genom3.md 3.2 N6.
    pub(super) fn find(&mut self, path: &Path, what: &str) -> Option<(Entity, Span)> {
        let found = self.scopes.find(self.scope, path);
        if found.is_none() {
            let last = path.segments.last().map_or("", |name| &name.text);
            if !path.segments.iter().any(|name| self.lost.contains(&name.text)) {
                let help = self.suggest(last, |this| this.scopes.candidates(this.scope, path));
                let mut error =
                    Diagnostic::error("E0206", path.span, format!("unknown {what} `{path}`"));
                error.help = help;
                self.push(error);
            }
        }
        found
    }

    /// Help with the nearest name. Limited in number: each looks at every name.
    pub(super) fn suggest<'s>(
        &'s mut self,
        word: &str,
        names: impl FnOnce(&'s Self) -> Vec<&'s str>,
    ) -> Option<String> {
        self.suggestions = self.suggestions.checked_sub(1)?;
        let this: &'s Self = self;
        let near = crate::parse::nearest(word, names(this).into_iter())?;
        Some(format!("did you mean `{near}`?"))
    }

    /// An entity in a message, with its article.
    pub(super) fn describe(&self, entity: Entity) -> &'static str {
        match entity {
            Entity::Type(ty) => self.article(ty),
            Entity::Const(_) => "a constant",
            Entity::Enumerator(..) => "an enumerator",
            Entity::Member => "a member",
            Entity::Port => "a port",
            Entity::Remote => "a remote",
            Entity::State => "a state",
        }
    }
}
