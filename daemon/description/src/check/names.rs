//! Declaring names, and resolving them (genom3.md 3.2, 4.2).

use super::Checker;
use super::room;
use super::scope::{Entity, ScopeId, ScopeKind, Sort};
use crate::diagnostic::Diagnostic;
use crate::model::Span;
use crate::syntax::{Name, Path};

impl Checker {
    /// Declares `name` in the current scope; reports why if it cannot.
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

    /// Whether `name` may be declared in a scope; reports why not.
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
        let module = self.scopes.kind(scope) == ScopeKind::Module;
        if module && sort != Sort::Member && self.scopes.own_name(scope) == Some(text) {
            let message = format!("`{text}` is already the name of what encloses it");
            let span = self.scopes.span(scope);
            self.push(Diagnostic::error("E0202", name.span, message).note(span, "declared here"));
            return false;
        }
        // Every component has a module `pause`, which a state of that name does not clash with.
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

    /// Enters a module, creating it if it is new.
    pub(super) fn open_module(&mut self, name: &Name) -> Option<ScopeId> {
        if self.scopes.own_name(self.scope) == Some(&*name.text) {
            let span = self.scopes.span(self.scope);
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

    /// A scope for a struct, union or exception; it cannot be found by name if the name is refused.
    pub(super) fn open_record(&mut self, name: &Name) -> (ScopeId, bool) {
        self.reserve(room::SCOPE, name.span);
        let own = self.scopes.own_name(self.scope) == Some(&*name.text);
        if own {
            let span = self.scopes.span(self.scope);
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

    /// Resolves a path; an unknown one is reported.
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

    /// The nearest name as help. Limited in number, since each search compares all names.
    pub(super) fn suggest<'s>(
        &'s mut self,
        word: &str,
        names: impl FnOnce(&'s Self) -> Vec<&'s str>,
    ) -> Option<String> {
        self.suggestions = self.suggestions.checked_sub(1)?;
        let this: &'s Self = self;
        genom_nearest::meant(word, names(this))
    }

    /// The kind of an entity for messages, with its article.
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
