//! Declarations of types: structs, unions, enums, exceptions, typedefs, natives, modules.

use std::collections::HashMap;

use genom_types::{Kind, Label, Member, TypeId, UnionMember};

use super::Checker;
use super::scope::{Entity, ScopeId, Sort};
use crate::diagnostic::Diagnostic;
use crate::model::Span;
use crate::syntax::{
    Case, Constructed, Declarator, Enum, Exception, Idl, Member as MemberSyntax, Name, Struct,
    TypeSpecKind, Typedef, Union,
};

impl Checker {
    pub(super) fn idl(&mut self, idl: &Idl) {
        if self.taken.full {
            return;
        }
        match idl {
            Idl::Module { name, statements } => {
                let Some(id) = self.open_module(name) else { return };
                let outer = std::mem::replace(&mut self.scope, id);
                statements.iter().for_each(|statement| self.idl(statement));
                self.scope = outer;
            }
            Idl::Const(dcl) => self.constant(dcl),
            Idl::Typedef(dcl) => self.typedef(dcl),
            Idl::Native(name) => {
                let full = self.scopes.full_name(self.scope).join(&name.text);
                self.declare_type(name, Kind::Native { name: full });
            }
            Idl::Exceptions(list) => {
                for dcl in list {
                    if self.taken.full {
                        break;
                    }
                    self.exception(dcl);
                }
            }
            Idl::Constructed(constructed) => _ = self.constructed(constructed),
            Idl::Forward { union, name } => self.forward(*union, name),
            Idl::Pragma(pragma, span) => self.pragma(pragma, *span),
        }
    }

    /// Adds a named type unless the name is in use.
    fn declare_type(&mut self, name: &Name, kind: Kind) -> Option<TypeId> {
        // Checked before adding, so that the table holds no type without a name.
        if !self.is_free(self.scope, name, Sort::Type, "E0201") {
            return None;
        }
        if self.is_too_deep(&kind, name.span) {
            self.lost.insert(name.text.clone());
            return None;
        }
        let id = self.add_type(kind, Some(name.span));
        self.scopes.set(self.scope, &name.text, Entity::Type(id), name.span);
        Some(id)
    }

    fn typedef(&mut self, dcl: &Typedef) {
        let ty = self.typedef_target(dcl);
        for declarator in &dcl.declarators {
            let ty = ty.and_then(|ty| self.declared(ty, declarator));
            let Some(target) = ty else {
                self.lost.insert(declarator.name.text.clone());
                continue;
            };
            let name = self.scopes.full_name(self.scope).join(&declarator.name.text);
            self.declare_type(&declarator.name, Kind::Typedef { name, target });
        }
    }

    /// The target of a typedef. It may be a type that is only announced, since its size is not
    /// needed.
    fn typedef_target(&mut self, dcl: &Typedef) -> Option<TypeId> {
        if let TypeSpecKind::Named(path) = &dcl.ty.kind
            && let Some((Entity::Type(ty), _)) = self.scopes.find(self.scope, path)
            && matches!(self.types.resolved(ty), Kind::Forward { .. })
            && dcl.declarators.iter().all(|declarator| declarator.dimensions.is_empty())
        {
            return Some(ty);
        }
        self.type_spec(&dcl.ty)
    }

    fn forward(&mut self, union: bool, name: &Name) {
        // A forward declaration of a type that exists already changes nothing.
        if let Some((Entity::Type(ty), _)) = self.scopes.local(self.scope, &name.text) {
            match self.types.kind(ty) {
                Kind::Forward { union: u, .. } if *u == union => return,
                Kind::Struct { .. } if !union => return,
                Kind::Union { .. } if union => return,
                _ => {}
            }
        }
        let full = self.scopes.full_name(self.scope).join(&name.text);
        let Some(id) = self.declare_type(name, Kind::Forward { name: full, union }) else { return };
        self.facts[id.index()].forward = true;
        self.forwards.push((id, name.span));
    }

    pub(super) fn constructed(&mut self, constructed: &Constructed) -> Option<TypeId> {
        let (id, name) = match constructed {
            Constructed::Struct(dcl) => (self.structure(dcl), &dcl.name),
            Constructed::Union(dcl) => (self.union(dcl), &dcl.name),
            Constructed::Enum(dcl) => (self.enumeration(dcl), &dcl.name),
        };
        if id.is_none() {
            self.lost.insert(name.text.clone());
        }
        id
    }

    /// Runs `f` in a scope of its own for a record named `name`.
    fn in_record<T>(&mut self, name: &Name, f: impl FnOnce(&mut Self) -> T) -> (T, bool) {
        let (id, named) = self.open_record(name);
        let outer = std::mem::replace(&mut self.scope, id);
        let result = f(self);
        self.scope = outer;
        (result, named)
    }

    /// Declares or completes a record.
    // genom3.md 3.2 N5, N9, N10.
    fn close_record(&mut self, name: &Name, union: bool, kind: Kind) -> Option<TypeId> {
        let Some((entity, span)) = self.scopes.local(self.scope, &name.text) else {
            return self.declare_type(name, kind);
        };
        if let Entity::Type(id) = entity {
            match self.types.kind(id) {
                Kind::Forward { union: u, .. } if *u == union => {
                    if span.file != name.span.file {
                        let message = format!(
                            "`{}` is defined in another file than it was announced in",
                            name.text
                        );
                        self.push(
                            Diagnostic::error("E0210", name.span, message)
                                .note(span, "announced here"),
                        );
                    }
                    self.is_too_deep(&kind, name.span);
                    self.complete_type(id, kind, name.span);
                    return Some(id);
                }
                Kind::Struct { .. } | Kind::Union { .. } if self.facts(id).forward => {
                    let message = format!("`{}` is already defined", name.text);
                    let place = self.facts(id).span.unwrap_or(span);
                    self.push(
                        Diagnostic::error("E0209", name.span, message).note(place, "defined here"),
                    );
                    return None;
                }
                Kind::Struct { .. } | Kind::Union { .. } | Kind::Exception { .. } => {}
                _ => {
                    self.clash_with_type(name, span);
                    return None;
                }
            }
        }
        self.clash_with_type(name, span);
        None
    }

    fn structure(&mut self, dcl: &Struct) -> Option<TypeId> {
        let (members, named) = self.in_record(&dcl.name, |this| this.members(&dcl.members));
        if !named {
            return None;
        }
        let name = self.scopes.full_name(self.scope).join(&dcl.name.text);
        self.close_record(&dcl.name, false, Kind::Struct { name, members })
    }

    fn exception(&mut self, dcl: &Exception) {
        let (members, named) = self.in_record(&dcl.name, |this| this.members(&dcl.members));
        let name = self.scopes.full_name(self.scope).join(&dcl.name.text);
        let made = named
            && match self.scopes.local(self.scope, &dcl.name.text) {
                None => self.declare_type(&dcl.name, Kind::Exception { name, members }).is_some(),
                Some((_, span)) => {
                    self.clash_with_type(&dcl.name, span);
                    false
                }
            };
        if !made {
            self.lost.insert(dcl.name.text.clone());
        }
    }

    /// Members of the record whose scope is the current one.
    pub(super) fn members(&mut self, list: &[MemberSyntax]) -> Vec<Member> {
        let mut members = Vec::new();
        for member in list {
            let ty = self.type_spec(&member.ty);
            for declarator in &member.declarators {
                let ty = ty.and_then(|ty| self.declared(ty, declarator));
                match ty {
                    Some(ty) if self.declare_member(self.scope, &declarator.name) => {
                        members.push(Member { name: declarator.name.text.to_string(), ty });
                    }
                    Some(_) => {}
                    None => _ = self.lost.insert(declarator.name.text.clone()),
                }
            }
        }
        members
    }

    pub(super) fn declare_member(&mut self, scope: ScopeId, name: &Name) -> bool {
        self.declare_in(scope, name, Entity::Member, "E0201")
    }

    fn enumeration(&mut self, dcl: &Enum) -> Option<TypeId> {
        // N13: a repeated enumerator is dropped, the enum stays.
        let name = self.scopes.full_name(self.scope).join(&dcl.name.text);
        let id = self.declare_type(&dcl.name, Kind::Enum { name, enumerators: Vec::new() })?;
        let mut kept = Vec::new();
        for enumerator in &dcl.enumerators {
            let rank = u32::try_from(kept.len()).unwrap_or(u32::MAX);
            let entity = Entity::Enumerator(id, rank);
            if self.declare_in(self.scope, enumerator, entity, "E0213") {
                kept.push(enumerator.text.to_string());
            }
        }
        let name = self.scopes.full_name(self.scope).join(&dcl.name.text);
        self.complete_type(id, Kind::Enum { name, enumerators: kept }, dcl.name.span);
        Some(id)
    }

    fn union(&mut self, dcl: &Union) -> Option<TypeId> {
        let (result, named) = self.in_record(&dcl.name, |this| this.union_body(dcl));
        let (discriminant, members) = result?;
        if !named {
            return None;
        }
        let name = self.scopes.full_name(self.scope).join(&dcl.name.text);
        self.close_record(&dcl.name, true, Kind::Union { name, discriminant, members })
    }

    // genom3.md 3.3 C7 to C11.
    fn union_body(&mut self, dcl: &Union) -> Option<(TypeId, Vec<UnionMember>)> {
        let switch_name = match &dcl.switch.kind {
            TypeSpecKind::Named(path) => path.segments.last().map(|name| name.text.clone()),
            TypeSpecKind::Constructed(inner) => {
                let name = match &**inner {
                    Constructed::Struct(dcl) => &dcl.name,
                    Constructed::Union(dcl) => &dcl.name,
                    Constructed::Enum(dcl) => &dcl.name,
                };
                let message =
                    format!("`{}` clashes with the type of the switch, itself", name.text);
                self.push(
                    Diagnostic::error("E0311", name.span, message)
                        .help("define the enum before the union"),
                );
                return None;
            }
            _ => None,
        };
        let discriminant = self.type_spec(&dcl.switch)?;
        let legal = matches!(
            self.types.resolved(discriminant),
            Kind::Boolean
                | Kind::Char
                | Kind::Short
                | Kind::UnsignedShort
                | Kind::Long
                | Kind::UnsignedLong
                | Kind::LongLong
                | Kind::UnsignedLongLong
                | Kind::Enum { .. }
        );
        if !legal {
            let message =
                format!("{} cannot select the members of a union", self.type_name(discriminant));
            self.push(
                Diagnostic::error("E0307", dcl.switch.span, message)
                    .help("use boolean, char, an integer type (not octet) or an enum"),
            );
            return None;
        }
        let mut taken = HashMap::new();
        let mut members = Vec::new();
        for (rank, case) in dcl.cases.iter().enumerate() {
            if switch_name.as_deref() == Some(&*case.declarator.name.text) {
                let name = &case.declarator.name;
                let message = format!("`{}` clashes with the type of the switch", name.text);
                self.push(
                    Diagnostic::error("E0311", name.span, message)
                        .note(dcl.switch.span, "the type of the switch"),
                );
                self.lost.insert(name.text.clone());
                continue;
            }
            let labels = self.labels(case, rank, discriminant, &mut taken);
            let ty = self.type_spec(&case.ty);
            match ty.and_then(|ty| self.declared(ty, &case.declarator)) {
                Some(ty) if self.declare_member(self.scope, &case.declarator.name) => {
                    let name = case.declarator.name.text.to_string();
                    members.push(UnionMember { name, ty, labels });
                }
                Some(_) => {}
                None => self.lose(&case.declarator),
            }
        }
        Some((discriminant, members))
    }

    fn lose(&mut self, declarator: &Declarator) {
        self.lost.insert(declarator.name.text.clone());
    }

    fn labels(
        &mut self,
        case: &Case,
        rank: usize,
        discriminant: TypeId,
        taken: &mut HashMap<Option<i128>, (usize, Span)>,
    ) -> Vec<Label> {
        let mut labels: Vec<Label> = Vec::new();
        for label in &case.labels {
            let value = match &label.value {
                None => Some(Label::Default),
                Some(expression) => {
                    let value = self.evaluate(expression);
                    // Error C8 replaces C5.
                    value
                        .and_then(|value| self.fit(value, discriminant, expression.span, "E0308"))
                        .and_then(|value| Self::label(&value))
                }
            };
            let Some(value) = value else { continue };
            let key = match value {
                Label::Value(v) => Some(v),
                Label::Default => None,
            };
            match taken.insert(key, (rank, label.span)) {
                Some((other, _)) if other == rank => {
                    let message = "this label is repeated for one member";
                    self.push(Diagnostic::warning("W0309", label.span, message));
                    continue;
                }
                Some((_, other)) => {
                    let message = "this label already selects another member";
                    self.push(
                        Diagnostic::error("E0310", label.span, message).note(other, "used here"),
                    );
                    continue;
                }
                None => {}
            }
            labels.push(value);
        }
        labels
    }

    /// Reports types that were announced and never defined.
    // genom3.md 3.2 N8.
    pub(super) fn check_forwards(&mut self) {
        for (id, span) in std::mem::take(&mut self.forwards) {
            if let Kind::Forward { name, union } = self.types.kind(id) {
                if self.lost.contains(name.last()) {
                    continue;
                }
                let what = if *union { "union" } else { "struct" };
                let message = format!("{what} `{name}` is announced and never defined");
                self.push(Diagnostic::error("E0208", span, message));
            }
        }
    }
}
