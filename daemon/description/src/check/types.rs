//! Types where they are used: resolves names, shares equal types, records what types contain.

use std::collections::HashSet;

use genom_types::{Kind, Member, TypeId};

use super::Checker;
use super::facts::{Facts, Shape};
use super::room;
use super::scope::Entity;
use crate::diagnostic::Diagnostic;
use crate::model::Span;
use crate::parse::MAX_DEPTH;
use crate::syntax::{Declarator, TypeSpec, TypeSpecKind};

impl Checker {
    pub(super) fn add_type(&mut self, kind: Kind, span: Option<Span>) -> TypeId {
        let mut facts = self.facts_of(&kind);
        facts.span = span;
        self.reserve(room::of_type(&kind), span.unwrap_or(self.place));
        let id = self.types.add(kind);
        if self.facts.len() <= id.index() {
            self.facts.resize(id.index() + 1, Facts::default());
        }
        self.facts[id.index()] = facts;
        id
    }

    pub(super) fn complete_type(&mut self, id: TypeId, kind: Kind, span: Span) {
        let mut facts = self.facts_of(&kind);
        facts.forward = self.facts[id.index()].forward;
        facts.span = Some(span);
        self.reserve(room::of_type(&kind), span);
        self.facts[id.index()] = facts;
        self.types.complete(id, kind);
    }

    /// Adds a member to the struct of an IDS.
    pub(super) fn grow_type(&mut self, id: TypeId, member: Member, span: Span) {
        let inner = self.facts(member.ty);
        if let Some(facts) = self.facts.get_mut(id.index()) {
            facts.depth = facts.depth.max(inner.depth + 1);
            facts.native |= inner.native;
            facts.open |= inner.open;
        }
        if inner.depth >= MAX_DEPTH {
            let message = format!("types nested deeper than {MAX_DEPTH} levels");
            self.push(Diagnostic::error("E0113", span, message));
        }
        self.types.add_member(id, member);
    }

    pub(super) fn facts(&self, id: TypeId) -> Facts {
        self.facts.get(id.index()).copied().unwrap_or_default()
    }

    fn facts_of(&self, kind: &Kind) -> Facts {
        let mut facts = Facts {
            depth: 1,
            native: matches!(kind, Kind::Native { .. }),
            open: matches!(kind, Kind::Forward { .. }),
            ..Facts::default()
        };
        let mut inside = |ty: TypeId| {
            let inner = self.facts(ty);
            facts.depth = facts.depth.max(inner.depth + 1);
            facts.native |= inner.native;
            facts.open |= inner.open;
        };
        match kind {
            Kind::Array { element, .. }
            | Kind::Sequence { element, .. }
            | Kind::Optional { element } => inside(*element),
            Kind::Typedef { target, .. } => inside(*target),
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                members.iter().for_each(|m| inside(m.ty));
            }
            Kind::Union { members, .. } => members.iter().for_each(|m| inside(m.ty)),
            _ => {}
        }
        facts
    }

    /// Reports types nested too deep, however they are composed.
    pub(super) fn is_too_deep(&mut self, kind: &Kind, span: Span) -> bool {
        let deep = self.facts_of(kind).depth > MAX_DEPTH;
        if deep {
            let message = format!("types nested deeper than {MAX_DEPTH} levels");
            self.push(Diagnostic::error("E0113", span, message));
        }
        deep
    }

    pub(super) fn shared(&mut self, shape: Shape, kind: impl FnOnce() -> Kind) -> TypeId {
        if let Some(id) = self.shapes.get(&shape) {
            return *id;
        }
        let id = self.add_type(kind(), None);
        self.shapes.insert(shape, id);
        id
    }

    /// A type that takes the place of one with an error.
    pub(super) fn error_type(&mut self) -> TypeId {
        if let Some(id) = self.error_type {
            return id;
        }
        let id = self.add_type(Kind::Any, None);
        self.error_type = Some(id);
        id
    }

    pub(super) fn is_error(&self, ty: TypeId) -> bool {
        self.error_type == Some(ty)
    }

    /// Resolves a type used by value; `None` after an error that was reported.
    pub(super) fn type_spec(&mut self, spec: &TypeSpec) -> Option<TypeId> {
        let ty = self.any_type(spec)?;
        self.by_value(ty, spec.span)
    }

    // genom3.md 3.2 N7, N11.
    fn by_value(&mut self, ty: TypeId, span: Span) -> Option<TypeId> {
        match self.types.resolved(ty) {
            Kind::Forward { union, name } => {
                let what = if *union { "union" } else { "struct" };
                let message = format!("{what} `{name}` is used before it is defined");
                let mut error = Diagnostic::error("E0207", span, message)
                    .help("define it before, or use it in a sequence");
                if let Some(place) = self.facts(self.types.resolve(ty)).span {
                    error = error.note(place, "announced here");
                }
                self.push(error);
                None
            }
            Kind::Exception { members, name } if members.is_empty() => {
                let message = format!("exception `{name}` has no members: it is no data type");
                self.push(Diagnostic::error("E0211", span, message));
                None
            }
            _ => Some(ty),
        }
    }

    fn any_type(&mut self, spec: &TypeSpec) -> Option<TypeId> {
        use TypeSpecKind as T;
        let basic = |this: &mut Self, name, kind| Some(this.shared(Shape::Basic(name), || kind));
        match &spec.kind {
            T::Boolean => basic(self, "boolean", Kind::Boolean),
            T::Char => basic(self, "char", Kind::Char),
            T::Octet => basic(self, "octet", Kind::Octet),
            T::Short => basic(self, "short", Kind::Short),
            T::UnsignedShort => basic(self, "ushort", Kind::UnsignedShort),
            T::Long => basic(self, "long", Kind::Long),
            T::UnsignedLong => basic(self, "ulong", Kind::UnsignedLong),
            T::LongLong => basic(self, "longlong", Kind::LongLong),
            T::UnsignedLongLong => basic(self, "ulonglong", Kind::UnsignedLongLong),
            T::Float => basic(self, "float", Kind::Float),
            T::Double => basic(self, "double", Kind::Double),
            T::Any => basic(self, "any", Kind::Any),
            T::Error => None,
            T::String(bound) => {
                let bound = match bound {
                    Some(bound) => Some(self.positive_u32(bound)?),
                    None => None,
                };
                Some(self.shared(Shape::String(bound), || Kind::String { bound }))
            }
            T::Sequence(element, bound) => {
                let inner = self.any_type(element);
                let bound = bound.as_ref().map(|bound| self.positive_u32(bound));
                let element_ty = self.element(inner?, element.span)?;
                let bound = match bound {
                    Some(bound) => Some(bound?),
                    None => None,
                };
                let shape = Shape::Sequence(element_ty, bound);
                Some(self.shared(shape, || Kind::Sequence { element: element_ty, bound }))
            }
            T::Optional(element) => {
                let element = self.type_spec(element)?;
                let shape = Shape::Optional(element);
                Some(self.shared(shape, || Kind::Optional { element }))
            }
            T::Named(path) => match self.find(path, "type")?.0 {
                Entity::Type(ty) => Some(ty),
                // A constant can be used as a type, and means its own type, as in GenoM3.
                Entity::Const(rank) => self.constants.get(rank).map(|constant| constant.ty),
                other => {
                    let what = self.describe(other);
                    let message = format!("`{path}` is {what}, not a type");
                    self.push(Diagnostic::error("E0206", path.span, message));
                    None
                }
            },
            T::Constructed(constructed) => self.constructed(constructed),
        }
    }

    /// Resolves the element of a sequence. It may be a type that is only announced: recursive types
    /// are made in this way.
    fn element(&mut self, ty: TypeId, span: Span) -> Option<TypeId> {
        match self.types.resolved(ty) {
            Kind::Forward { .. } => Some(ty),
            _ => self.by_value(ty, span),
        }
    }

    /// The type of a declarator: `ty` with the dimensions.
    pub(super) fn declared(&mut self, ty: TypeId, declarator: &Declarator) -> Option<TypeId> {
        let mut ty = ty;
        for dimension in declarator.dimensions.iter().rev() {
            let (element, length) = (ty, self.positive_u32(dimension)?);
            let kind = Kind::Array { element, length };
            if self.is_too_deep(&kind, declarator.name.span) {
                return None;
            }
            ty = self.shared(Shape::Array(element, length), || kind);
        }
        Some(ty)
    }

    /// Whether a native is inside, for rules S12 and S19.
    pub(super) fn contains_native(&self, ty: TypeId) -> bool {
        let facts = self.facts(ty);
        if facts.native || !facts.open {
            return facts.native;
        }
        let mut seen = HashSet::new();
        let mut todo = vec![ty];
        while let Some(id) = todo.pop() {
            if !seen.insert(id) {
                continue;
            }
            match self.types.kind(id) {
                Kind::Native { .. } => return true,
                Kind::Array { element, .. }
                | Kind::Sequence { element, .. }
                | Kind::Optional { element } => todo.push(*element),
                Kind::Typedef { target, .. } => todo.push(*target),
                Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                    todo.extend(members.iter().map(|m| m.ty));
                }
                Kind::Union { members, .. } => todo.extend(members.iter().map(|m| m.ty)),
                _ => {}
            }
        }
        false
    }

    /// The type behind typedefs and optionals, through which paths and initialisers lead.
    pub(super) fn walked(&self, mut ty: TypeId) -> TypeId {
        loop {
            ty = self.types.resolve(ty);
            match self.types.kind(ty) {
                Kind::Optional { element } => ty = *element,
                _ => return ty,
            }
        }
    }

    /// A member of a struct, union or exception, by name.
    pub(super) fn member(&mut self, ty: TypeId, name: &str) -> Option<(usize, TypeId)> {
        const SMALL: usize = 16;
        let at = |members: &[Member]| {
            members.iter().enumerate().find(|(_, m)| m.name == name).map(|(i, m)| (i, m.ty))
        };
        match self.types.kind(ty) {
            Kind::Struct { members, .. } | Kind::Exception { members, .. }
                if members.len() <= SMALL =>
            {
                at(members)
            }
            // Large structs (the IDS of a large component) have an index by name.
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                let index = self.member_index.entry(ty).or_default();
                for (rank, member) in members.iter().enumerate().skip(index.len()) {
                    index.insert(member.name.clone(), rank);
                }
                let rank = *index.get(name)?;
                members.get(rank).map(|member| (rank, member.ty))
            }
            Kind::Union { members, .. } => {
                members.iter().enumerate().find(|(_, m)| m.name == name).map(|(i, m)| (i, m.ty))
            }
            _ => None,
        }
    }

    /// A type as it is named in messages.
    pub(super) fn type_name(&self, ty: TypeId) -> String {
        match self.types.kind(ty) {
            Kind::Boolean => "boolean".to_owned(),
            Kind::Char => "char".to_owned(),
            Kind::Octet => "octet".to_owned(),
            Kind::Short => "short".to_owned(),
            Kind::UnsignedShort => "unsigned short".to_owned(),
            Kind::Long => "long".to_owned(),
            Kind::UnsignedLong => "unsigned long".to_owned(),
            Kind::LongLong => "long long".to_owned(),
            Kind::UnsignedLongLong => "unsigned long long".to_owned(),
            Kind::Float => "float".to_owned(),
            Kind::Double => "double".to_owned(),
            Kind::Any => "any".to_owned(),
            Kind::String { bound: None } => "string".to_owned(),
            Kind::String { bound: Some(n) } => format!("string<{n}>"),
            Kind::Array { element, length } => format!("{}[{length}]", self.type_name(*element)),
            Kind::Sequence { element, bound: None } => {
                format!("sequence<{}>", self.type_name(*element))
            }
            Kind::Sequence { element, bound: Some(n) } => {
                format!("sequence<{}, {n}>", self.type_name(*element))
            }
            Kind::Optional { element } => format!("optional<{}>", self.type_name(*element)),
            named => {
                let name = named.name().map(ToString::to_string).unwrap_or_default();
                let what = self.article(ty).split(' ').nth(1).unwrap_or_default();
                format!("{what} `{name}`")
            }
        }
    }

    /// The kind of a type for messages, with its article.
    pub(super) fn article(&self, ty: TypeId) -> &'static str {
        match self.types.kind(ty) {
            Kind::Enum { .. } => "an enum",
            Kind::Struct { .. } | Kind::Forward { union: false, .. } => "a struct",
            Kind::Union { .. } | Kind::Forward { .. } => "a union",
            Kind::Exception { .. } => "an exception",
            Kind::Typedef { .. } => "a typedef",
            Kind::Native { .. } => "a native",
            _ => "a type",
        }
    }
}
