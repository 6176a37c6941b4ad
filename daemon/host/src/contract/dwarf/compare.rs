//! Compares a codel's function with its description: arguments by genom3.md 5.5, layouts by 5.2.

use std::collections::HashSet;

use genom_description::model::{
    Codel, CodelParameter, Direction, Parameter, Port, PortDirection, Source,
};
use genom_runtime::plan::Plan;
use genom_types::{DataType, Kind, TypeId, TypeTable};
use gimli::DwAte;

use super::super::mismatch::{Agreement, Mismatch};
use crate::ffi::{Class, Scalar};
use genom_elf::debug::{At, Composite, DebugInfo, Function, Member, Node};

/// One comparison of a library with a plan.
pub(super) struct Comparison<'a> {
    pub(super) info: &'a DebugInfo<'a>,
    pub(super) plan: &'a Plan,
    /// Whether the codels are in C++ (genom3.md 6).
    cxx: bool,
    /// Pairs found equal, or being compared by a caller, or reported already.
    seen: HashSet<(TypeId, At)>,
}

impl<'a> Comparison<'a> {
    /// A comparison without results yet.
    pub(super) fn new(info: &'a DebugInfo<'a>, plan: &'a Plan) -> Self {
        let cxx = plan.component().lang == "c++";
        Self { info, plan, cxx, seen: HashSet::new() }
    }

    pub(super) fn types(&self) -> &'a TypeTable {
        &self.plan.specification().types
    }

    /// Compares a codel with the function of its name.
    pub(super) fn codel(&mut self, codel: &Codel, function: &Function) -> Agreement {
        let wanted = codel.parameters.len() + usize::from(!self.cxx);
        let found = function.parameters.len();
        if wanted != found {
            let and = if self.cxx { ";" } else { ", the context included;" };
            let (what, takes) = ("arguments", "takes");
            return Err(Mismatch::Count { what, wanted, and, takes, found });
        }
        for (rank, (parameter, (_, at))) in
            codel.parameters.iter().zip(&function.parameters).enumerate()
        {
            self.argument(parameter, *at)
                .map_err(|why| why.within(format!("argument {} `{}`", rank + 1, parameter.name)))?;
        }
        if !self.cxx {
            let context = function.parameters.last().and_then(|(_, at)| *at);
            self.pointer(context).map_err(|why| why.within("the context"))?;
        }
        self.pointer(function.result).map_err(|why| why.within("the result"))?;
        Ok(())
    }

    fn argument(&mut self, parameter: &CodelParameter, at: Option<At>) -> Agreement {
        let model = self.plan.component();
        match parameter.source {
            Source::Port(rank) => {
                let port = model.ports.get(rank).ok_or(Mismatch::Absent("port"))?;
                if self.cxx { self.abstract_port(port, at) } else { self.port(port, at) }
            }
            Source::Remote(rank) => {
                let remote = model.remotes.get(rank).ok_or(Mismatch::Absent("remote"))?;
                match self.cxx {
                    true => self.abstract_remote(&remote.parameters, at),
                    false => self.remote(&remote.parameters, at),
                }
            }
            _ => self.passed(parameter.ty, parameter.direction, at),
        }
    }

    /// Compares a datum passed as an argument (genom3.md 5.5).
    pub(super) fn passed(&mut self, ty: TypeId, direction: Direction, at: Option<At>) -> Agreement {
        let kind = self.types().resolved(ty);
        let class = match self.cxx {
            true => Class::of_cxx(kind, direction),
            false => Class::of(kind, direction),
        };
        match class {
            Class::Value(scalar) => self.scalar(ty, scalar, at),
            Class::Held => self.memory(ty, at),
            Class::Address => {
                let Some(target) = self.pointer(at)? else { return Ok(()) };
                // The parameter `T x[a][b]` is a pointer to `T[b]`, but `T (*x)[a][b]` is one to
                // the whole array.
                let (lengths, element) = self.dimensions(ty);
                if let Some((_, rest)) = lengths.split_first() {
                    return self
                        .array(rest, element, target)
                        .or_else(|why| self.array(&lengths, element, target).map_err(|_| why));
                }
                self.memory(ty, Some(target))
            }
        }
    }

    /// The target of a pointer; `None` for `void *`, which may point to anything.
    pub(super) fn pointer(&self, at: Option<At>) -> Result<Option<At>, Mismatch> {
        match self.info.stripped(at) {
            Some((_, Node::Pointer(target) | Node::Reference(target))) => {
                Ok(target.filter(|_| self.info.stripped(target).is_some()))
            }
            Some((_, Node::Unknown)) => Ok(None),
            _ => Err(Mismatch::other("a pointer", self.spelled(at))),
        }
    }

    pub(super) fn differ(&self, ty: TypeId, at: Option<At>) -> Agreement {
        let wanted = if self.cxx { self.in_cxx(ty) } else { self.types().c_name(ty) };
        Err(Mismatch::other(format!("`{wanted}`"), self.spelled(at)))
    }

    /// The type in the library, for messages.
    pub(super) fn spelled(&self, at: Option<At>) -> String {
        format!("`{}`", self.info.spell(at))
    }

    fn scalar(&self, ty: TypeId, scalar: Scalar, at: Option<At>) -> Agreement {
        let agrees = match self.info.stripped(at) {
            Some((_, Node::Base { size, encoding, .. })) => fits(scalar, size, encoding),
            // A C enum of 4 bytes is accepted for uint32_t.
            Some((_, Node::Enum { size, .. })) => scalar == Scalar::U32 && size == 4,
            Some((_, Node::Unknown)) => true,
            _ => false,
        };
        if agrees { Ok(()) } else { self.differ(ty, at) }
    }

    /// Compares a datum in memory.
    pub(super) fn memory(&mut self, ty: TypeId, at: Option<At>) -> Agreement {
        let types = self.types();
        let ty = types.resolve(ty);
        let Some((place, node)) = self.info.stripped(at) else { return self.differ(ty, at) };
        if let Class::Value(scalar) = Class::of(types.kind(ty), Direction::In) {
            return self.scalar(ty, scalar, at);
        }
        if matches!(node, Node::Unknown) || !self.seen.insert((ty, place)) {
            return Ok(());
        }
        if self.cxx {
            return self.object(ty, place, node, at);
        }
        match (types.kind(ty), node) {
            (Kind::Native { .. }, Node::Pointer(_)) => Ok(()),
            (Kind::String { bound: None }, Node::Pointer(target)) => {
                if self.is_character(target) {
                    Ok(())
                } else {
                    self.differ(ty, at)
                }
            }
            (Kind::Array { .. } | Kind::String { bound: Some(_) }, Node::Array { .. }) => {
                let (lengths, element) = self.dimensions(ty);
                self.array(&lengths, element, place)
            }
            (Kind::Union { .. }, Node::Struct(found)) => self.union(ty, &found, at),
            (
                Kind::Sequence { .. }
                | Kind::Optional { .. }
                | Kind::Struct { .. }
                | Kind::Exception { .. },
                Node::Struct(found),
            ) => self.structure(ty, &found, at),
            _ => self.differ(ty, at),
        }
    }

    fn is_character(&self, at: Option<At>) -> bool {
        match self.info.stripped(at) {
            Some((_, Node::Base { size, .. })) => size == 1,
            found => matches!(found, Some((_, Node::Unknown))),
        }
    }

    /// Lengths of all dimensions, and the element; bounded strings count as arrays of characters.
    pub(super) fn dimensions(&self, ty: TypeId) -> (Vec<u64>, Option<TypeId>) {
        let (mut lengths, mut ty) = (Vec::new(), ty);
        loop {
            match self.types().resolved(ty) {
                Kind::Array { element, length } => {
                    lengths.push(u64::from(*length));
                    ty = *element;
                }
                Kind::String { bound: Some(bound) } => {
                    lengths.push(u64::from(*bound));
                    return (lengths, None);
                }
                _ => return (lengths, Some(ty)),
            }
        }
    }

    /// Compares an array; `element` is `None` for characters.
    pub(super) fn array(&mut self, lengths: &[u64], element: Option<TypeId>, at: At) -> Agreement {
        let (mut found, mut inner) = (Vec::new(), Some(at));
        while let Some((_, Node::Array { element, lengths })) = self.info.stripped(inner) {
            found.extend(lengths);
            inner = element;
        }
        let wanted: Vec<_> = lengths.iter().map(|length| Some(*length)).collect();
        if found != wanted {
            let length = |length: &u64| format!("[{length}]");
            let wanted: String = lengths.iter().map(length).collect();
            let wanted = if wanted.is_empty() { "a single element".to_owned() } else { wanted };
            return Err(Mismatch::other(format!("an array {wanted}"), self.spelled(Some(at))));
        }
        match element {
            Some(element) => self.memory(element, inner),
            None if self.is_character(inner) => Ok(()),
            None => Err(Mismatch::others("characters", self.spelled(inner))),
        }
    }

    fn structure(&mut self, ty: TypeId, found: &Composite, at: Option<At>) -> Agreement {
        let types = self.types();
        let data = DataType::new(&self.plan.specification().types, ty)?;
        let wanted: Vec<(String, usize, Part)> = match types.kind(ty) {
            Kind::Sequence { element, bound } => {
                let buffer = match bound {
                    Some(bound) => Part::Elements(*element, u64::from(*bound)),
                    None => Part::Pointer(*element),
                };
                let parts =
                    [("_maximum", Part::Word), ("_length", Part::Word), ("_buffer", buffer)];
                let release = bound.is_none().then_some(("_release", Part::Any));
                let parts = parts.into_iter().chain(release);
                let offsets = data.layout().offsets.iter().copied();
                parts.zip(offsets).map(|((name, part), at)| (name.to_owned(), at, part)).collect()
            }
            Kind::Optional { element } => {
                let value = data.layout().offsets.first().copied().unwrap_or_default();
                let present = ("_present".to_owned(), 0, Part::Flag);
                vec![present, ("_value".to_owned(), value, Part::Datum(*element))]
            }
            _ => {
                let members = types.members(ty).iter().enumerate();
                let part = |(rank, member): (usize, &genom_types::Member)| {
                    let offset = data.member_offset(rank).unwrap_or_default();
                    (member.name.clone(), offset, Part::Datum(member.ty))
                };
                members.map(part).collect()
            }
        };
        self.members(&types.c_name(ty), wanted, data.size(), found, at)
    }

    /// Compares the members by name, offset and type, and the size of the struct.
    pub(super) fn members(
        &mut self,
        name: &str,
        wanted: Vec<(String, usize, Part)>,
        whole: usize,
        found: &Composite,
        at: Option<At>,
    ) -> Agreement {
        // The unit has only a forward declaration: nothing to compare.
        let Some(size) = found.size else { return Ok(()) };
        let names = |names: Vec<&str>| names.join(", ");
        let (ours, theirs) = (
            names(wanted.iter().map(|part| part.0.as_str()).collect()),
            names(found.members.iter().map(|member| member.name.as_str()).collect()),
        );
        if ours != theirs {
            return Err(Mismatch::Members {
                ours: name.to_owned(),
                wanted: ours,
                theirs: self.info.spell(at),
                found: theirs,
            });
        }
        for ((member, offset, part), found) in wanted.into_iter().zip(&found.members) {
            let place = |why: Mismatch| why.within(format!("`{name}.{member}`"));
            self.part(part, found).map_err(place)?;
            if offset as u64 != found.offset {
                let (wanted, found) = (offset as u64, found.offset);
                return Err(place(Mismatch::Number { what: "offset", wanted, found }));
            }
        }
        if size != whole as u64 {
            let number = Mismatch::Number { what: "size", wanted: whole as u64, found: size };
            return Err(number.within(format!("`{name}`")));
        }
        Ok(())
    }

    fn part(&mut self, part: Part, found: &Member) -> Agreement {
        match part {
            Part::Any => Ok(()),
            Part::Datum(ty) => self.memory(ty, found.ty),
            Part::Word | Part::Flag | Part::Size => {
                let size = match part {
                    Part::Word => 4,
                    Part::Size => 8,
                    _ => 1,
                };
                match self.info.stripped(found.ty) {
                    Some((_, Node::Base { size: has, .. })) if has == size => Ok(()),
                    _ => Err(Mismatch::others(format!("{size} bytes"), self.spelled(found.ty))),
                }
            }
            Part::Pointer(element) => match self.pointer(found.ty)? {
                Some(target) => self.memory(element, Some(target)),
                None => Ok(()),
            },
            Part::Elements(element, count) => {
                let at = found.ty.ok_or(Mismatch::NoArray)?;
                let (mut lengths, element) = self.dimensions(element);
                lengths.insert(0, count);
                self.array(&lengths, element, at)
            }
        }
    }

    /// Compares `struct U { D _d; union { members } _u; }`.
    pub(super) fn union(&mut self, ty: TypeId, found: &Composite, at: Option<At>) -> Agreement {
        let Some(size) = found.size else { return Ok(()) };
        let Kind::Union { discriminant, members, .. } = self.types().kind(ty) else {
            return self.differ(ty, at);
        };
        let name = self.types().c_name(ty);
        let data = DataType::new(&self.plan.specification().types, ty)?;
        let [tag, body] = found.members.as_slice() else { return self.differ(ty, at) };
        self.memory(*discriminant, tag.ty).map_err(|why| why.within(format!("`{name}._d`")))?;
        let Some((_, Node::Union(found))) = self.info.stripped(body.ty) else {
            return Err(Mismatch::NoUnion(name));
        };
        if size != data.size() as u64 || tag.offset != 0 || found.members.len() != members.len() {
            return self.differ(ty, at);
        }
        for (rank, (wanted, found)) in members.iter().zip(&found.members).enumerate() {
            let offset = data.member_offset(rank).unwrap_or_default() as u64;
            if wanted.name != found.name || offset != body.offset + found.offset {
                let wanted = format!("`{name}._u.{}`", wanted.name);
                return Err(Mismatch::other(wanted, format!("`{}`", found.name)));
            }
            self.memory(wanted.ty, found.ty)
                .map_err(|why| why.within(format!("`{name}._u.{}`", wanted.name)))?;
        }
        Ok(())
    }

    /// Compares the handle of a port (genom3.md 5.7).
    fn port(&mut self, port: &Port, at: Option<At>) -> Agreement {
        let methods: &[&str] = match (port.direction, port.multiple) {
            (PortDirection::In, _) => &["data", "read"],
            (PortDirection::Out, false) => &["data", "write"],
            (PortDirection::Out, true) => &["data", "write", "open", "close"],
        };
        let Some(handle) = self.handle(at, methods)? else { return Ok(()) };
        let data = handle.members.first().map_or(Ok(None), |data| self.pointer(data.ty))?;
        let Some((_, Node::Function(data))) = self.info.stripped(data) else { return Ok(()) };
        let wanted = if port.multiple { 2 } else { 1 };
        if data.parameters.len() != wanted {
            return Err(match port.multiple {
                true => Mismatch::Methods { kind: "multiple", arguments: "2 arguments" },
                false => Mismatch::Methods { kind: "simple", arguments: "1 arguments" },
            });
        }
        self.passed(port.ty, Direction::Out, data.result).map_err(|why| why.within("its data"))
    }

    /// Compares the handle of a remote (genom3.md 5.8).
    fn remote(&mut self, parameters: &[Parameter], at: Option<At>) -> Agreement {
        let Some(handle) = self.handle(at, &["call"])? else { return Ok(()) };
        let call = handle.members.first().map_or(Ok(None), |call| self.pointer(call.ty))?;
        let Some((_, Node::Function(call))) = self.info.stripped(call) else { return Ok(()) };
        let (wanted, found) = (parameters.len() + 1, call.parameters.len());
        if wanted != found {
            return Err(Mismatch::Call { wanted, found });
        }
        for (parameter, (_, at)) in parameters.iter().zip(&call.parameters) {
            self.passed(parameter.ty, parameter.direction, *at)
                .map_err(|why| why.within(format!("argument `{}` of its call", parameter.name)))?;
        }
        Ok(())
    }

    /// Finds a struct of functions; `None` when the library only declares it.
    fn handle(&self, at: Option<At>, methods: &[&str]) -> Result<Option<Composite>, Mismatch> {
        let target = self.pointer(at)?;
        let Some((_, node)) = self.info.stripped(target) else { return Ok(None) };
        let Node::Struct(found) = node else {
            return Err(Mismatch::other("a handle", self.spelled(at)));
        };
        if found.size.is_none() {
            return Ok(None);
        }
        let names: Vec<&str> = found.members.iter().map(|member| member.name.as_str()).collect();
        if names != methods {
            let (wanted, found) = (methods.join(", "), names.join(", "));
            let wanted = format!("a handle with {wanted}");
            return Err(Mismatch::other(wanted, format!("one with {found}")));
        }
        Ok(Some(found))
    }
}

/// A member of a C struct that represents an IDL type.
pub(super) enum Part {
    /// A datum of this type.
    Datum(TypeId),
    /// A pointer to such data.
    Pointer(TypeId),
    /// This number of consecutive data.
    Elements(TypeId, u64),
    /// `uint32_t`.
    Word,
    /// `size_t`.
    Size,
    /// `bool`.
    Flag,
    /// Not compared.
    Any,
}

/// Whether a basic type of C has the size and the encoding of a scalar.
fn fits(scalar: Scalar, size: u64, encoding: DwAte) -> bool {
    let signed = [gimli::DW_ATE_signed, gimli::DW_ATE_signed_char].contains(&encoding);
    let unsigned = [gimli::DW_ATE_unsigned, gimli::DW_ATE_unsigned_char].contains(&encoding);
    match scalar {
        Scalar::Bool => size == 1 && (encoding == gimli::DW_ATE_boolean || unsigned),
        // Whether plain `char` is signed depends on the platform.
        Scalar::I8 => size == 1 && (signed || encoding == gimli::DW_ATE_unsigned_char),
        Scalar::U8 => size == 1 && unsigned,
        Scalar::I16 => size == 2 && signed,
        Scalar::U16 => size == 2 && unsigned,
        Scalar::I32 => size == 4 && signed,
        Scalar::U32 => size == 4 && unsigned,
        Scalar::I64 => size == 8 && signed,
        Scalar::U64 => size == 8 && unsigned,
        Scalar::F32 => size == 4 && encoding == gimli::DW_ATE_float,
        Scalar::F64 => size == 8 && encoding == gimli::DW_ATE_float,
    }
}
