//! Properties of components and interfaces, and what properties have in common (genom3.md 3.5).

use std::collections::HashMap;

use genom_types::{Kind, TypeId};
use indexmap::{IndexMap, IndexSet};

use super::Checker;
use super::scope::Entity;
use super::state::{BodyId, Given, add_new, add_throws};
use crate::diagnostic::Diagnostic;
use crate::model::{Dialect, Span};
use crate::syntax::{Name, Path, Property, PropertyKind, Text};

impl Checker {
    pub(super) fn body_property(&mut self, id: BodyId, property: &Property) {
        use PropertyKind as K;
        let keyword = &property.keyword;
        self.check_colon(id, property);
        match &property.kind {
            K::Doc(text) => self.bodies[id].docs.push(text.text.clone()),
            K::Version(text) => {
                let mut slot = self.bodies[id].version.take();
                self.give(&mut slot, text.text.clone(), keyword);
                self.bodies[id].version = slot;
            }
            K::Lang(text) => {
                let mut slot = self.bodies[id].lang.take();
                self.give(&mut slot, text.text.clone(), keyword);
                self.bodies[id].lang = slot;
            }
            K::Email(text) => {
                let mut slot = self.bodies[id].email.take();
                self.give(&mut slot, text.text.clone(), keyword);
                self.bodies[id].email = slot;
            }
            K::ClockRate(quantity) => {
                let Some(seconds) = self.seconds(quantity, "clock-rate") else { return };
                let mut slot = self.bodies[id].clock_rate.take();
                self.give(&mut slot, seconds, keyword);
                self.bodies[id].clock_rate = slot;
            }
            K::Stack(value, unit) => {
                let Some(bytes) = self.positive(value) else { return };
                let mut slot = self.bodies[id].stack.take();
                self.give(&mut slot, bytes.saturating_mul(*unit), keyword);
                self.bodies[id].stack = slot;
            }
            K::RealTime => {
                let mut slot = self.bodies[id].real_time.take();
                self.give(&mut slot, (), keyword);
                self.bodies[id].real_time = slot;
            }
            K::Requires(list) => {
                let fresh = self.strings(list);
                add_new(&mut self.bodies[id].requires, fresh);
            }
            // genom3.md appendix D: may be repeated since 2.99.41.
            K::CodelsRequire(list) => {
                let fresh = self.strings(list);
                add_new(&mut self.bodies[id].codels_requires, fresh);
            }
            K::Throws(list) => {
                let fresh = self.throws(id, list);
                add_throws(&mut self.bodies[id].throws, &fresh);
            }
            K::Provides(names) | K::Extends(names) => self.inherit(id, names, false),
            K::Uses(names) => self.inherit(id, names, true),
            K::IdsType(path) => self.ids_type(id, path),
            // S16.
            K::Local(..) => {
                let message = "local variables belong to functions and activities";
                self.push(Diagnostic::error("E0616", keyword.span, message));
            }
            // P1.
            _ => {
                let what = if self.bodies[id].interface { "interfaces" } else { "components" };
                let message = format!("`{}` is no property of {what}", keyword.text);
                self.push(Diagnostic::error("E0501", keyword.span, message));
            }
        }
    }

    /// Refuses the `:` after a property, which only the papers' dialects have.
    pub(super) fn check_colon(&mut self, id: BodyId, property: &Property) {
        if let Some(span) = property.colon
            && self.bodies[id].dialect == Dialect::Current
        {
            let message = format!("no `:` comes after `{}`", property.keyword.text);
            self.push(Diagnostic::error("E0103", span, message).help("remove the `:`"));
        }
    }

    /// Sets a property that can be set only once.
    // genom3.md 3.5 P6.
    pub(super) fn give<T>(&mut self, slot: &mut Given<T>, value: T, keyword: &Name) {
        match slot {
            None => *slot = Some((value, keyword.span)),
            Some((_, first)) => {
                let message = format!("`{}` is already given", keyword.text);
                self.push(
                    Diagnostic::error("E0506", keyword.span, message).note(*first, "given here"),
                );
            }
        }
    }

    // genom3.md 3.5 P7.
    fn strings(&mut self, list: &[Text]) -> Vec<String> {
        let mut strings: IndexSet<String> = IndexSet::new();
        for text in list {
            if !strings.insert(text.text.clone()) {
                let message = format!("{:?} is listed twice", text.text);
                self.push(Diagnostic::warning("W0507", text.span, message));
            }
        }
        strings.into_iter().collect()
    }

    /// The exceptions of one list.
    // genom3.md 3.5 P14, P15.
    pub(super) fn throws(&mut self, id: BodyId, list: &[Path]) -> IndexSet<TypeId> {
        let mut found: IndexMap<TypeId, Span> = IndexMap::new();
        for path in list {
            let Some(ty) = self.exception_named(id, path) else { continue };
            if let Some(first) = found.get(&ty) {
                let message = format!("exception `{path}` is listed twice");
                let first = *first;
                self.push(
                    Diagnostic::error("E0515", path.span, message).note(first, "listed here"),
                );
                continue;
            }
            found.insert(ty, path.span);
        }
        found.into_keys().collect()
    }

    fn exception_named(&mut self, id: BodyId, path: &Path) -> Option<TypeId> {
        let scope = self.bodies[id].scope;
        // dialects.md A: in the papers' dialects, `throws` declares the exception.
        if self.bodies[id].dialect != Dialect::Current
            && self.scopes.find(scope, path).is_none()
            && let [name] = &*path.segments
        {
            let full = self.scopes.full_name(scope).join(&name.text);
            let outer = std::mem::replace(&mut self.scope, scope);
            let kind = Kind::Exception { name: full, members: Vec::new() };
            let ty = self.add_type(kind, Some(name.span));
            self.declare(name, Entity::Type(ty));
            self.scope = outer;
            return Some(ty);
        }
        let (entity, span) = self.find(path, "exception")?;
        if let Entity::Type(ty) = entity {
            let ty = self.types.resolve(ty);
            if matches!(self.types.kind(ty), Kind::Exception { .. }) {
                return Some(ty);
            }
        }
        let message = format!("`{path}` is {}, not an exception", self.describe(entity));
        self.push(Diagnostic::error("E0514", path.span, message).note(span, "declared here"));
        None
    }

    /// `provides`, `uses` and `extends`.
    // genom3.md 3.4 I2 to I4, I8.
    fn inherit(&mut self, id: BodyId, names: &[Name], flip: bool) {
        let mut listed: HashMap<&str, Span> = HashMap::new();
        for name in names {
            let Some(other) = self.interface(&name.text, name.span, "E0402") else { continue };
            if let Some(first) = listed.insert(&name.text, name.span) {
                let message = format!("interface `{}` is listed twice", name.text);
                self.push(
                    Diagnostic::error("E0404", name.span, message).note(first, "listed here"),
                );
                continue;
            }
            if other == id {
                let message = format!("`{}` cannot extend itself", name.text);
                self.push(Diagnostic::error("E0402", name.span, message));
                continue;
            }
            self.merge(id, other, flip, name.span);
            if self.taken.full {
                return;
            }
        }
    }

    /// `ids: T;`
    // dialects.md A.
    fn ids_type(&mut self, id: BodyId, path: &Path) {
        let Some((entity, span)) = self.find(path, "struct") else { return };
        let ty = match entity {
            Entity::Type(ty) => self.types.resolve(ty),
            _ => self.error_type(),
        };
        let Kind::Struct { members, .. } = self.types.kind(ty) else {
            let message =
                format!("`{path}` is {}, the IDS must be a struct", self.describe(entity));
            self.push(Diagnostic::error("E0714", path.span, message).note(span, "declared here"));
            return;
        };
        let members = vec![span; members.len()];
        if self.bodies[id].ids.is_some() {
            let message = "the IDS is already declared";
            self.push(Diagnostic::error("E0506", path.span, message));
            return;
        }
        self.bodies[id].ids = Some(ty);
        self.bodies[id].ids_members = members;
    }
}
