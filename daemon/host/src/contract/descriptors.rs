//! Compares the table that the Rust SDK exports with a component: names, arguments, layouts.

use std::collections::{HashMap, HashSet};

use genom::abi::{self, Passing};
use genom_description::model::{
    Codel as ModelCodel, CodelParameter, Direction, PortDirection, Remote, Source, Span,
};
use genom_runtime::plan::Plan;
use genom_types::{DataType, Kind, TypeId};

use super::declare;
use super::difference::Difference;
use super::mismatch::{Agreement, Mismatch};
use super::table::{Argument, Table, Type};
use crate::ffi::Class;

/// Compares every codel of the table that the component has; returns how many, and the differences.
pub(super) fn compare(
    table: &Table,
    plan: &Plan,
    locate: &dyn Fn(Span) -> String,
) -> (usize, Vec<Difference>) {
    let model = plan.component();
    let types = &plan.specification().types;
    let told: HashMap<_, _> =
        table.codels.iter().map(|codel| (codel.name.as_str(), codel)).collect();
    let mut compared = 0;
    let mut differences = Vec::new();
    let mut comparison = Comparison { table, plan, seen: HashSet::new() };
    for codel in &model.codels {
        let Some(told) = told.get(codel.name.as_str()) else { continue };
        compared += 1;
        if let Err(why) = comparison.codel(codel, &told.arguments) {
            let arguments = told.arguments.iter().map(|argument| show_argument(table, argument));
            differences.push(Difference {
                subject: format!("codel `{}`", codel.name),
                place: locate(codel.span),
                why: why.to_string(),
                description: declare::codel(model, types, codel),
                library: format!("fn {}({})", codel.name, arguments.collect::<Vec<_>>().join(", ")),
            });
        }
    }
    for &rank in &table.exceptions {
        let exception = &table.types[rank];
        let name = exception.name.as_deref().unwrap_or_default();
        let declared = types.iter().find(|(_, kind)| {
            matches!(kind, Kind::Exception { name: found, .. } if found.to_string() == name)
        });
        let mut compare = |id: TypeId| {
            if types.members(id).is_empty() && exception.members.is_empty() {
                return Ok(());
            }
            comparison.ty(id, Some(rank))
        };
        let why = match declared {
            None => "the description declares no such exception".to_owned(),
            Some((id, _)) => match compare(id) {
                Ok(()) => continue,
                Err(why) => why.to_string(),
            },
        };
        differences.push(Difference {
            subject: format!("exception {name}"),
            place: locate(model.span),
            why,
            description: declared.map_or(String::new(), |(id, _)| types.spelling(id)),
            library: show(table, Some(rank)),
        });
    }
    (compared, differences)
}

/// One comparison of a library with a plan.
struct Comparison<'a> {
    table: &'a Table,
    plan: &'a Plan,
    /// Pairs found equal, or being compared by a caller.
    seen: HashSet<(TypeId, usize)>,
}

impl Comparison<'_> {
    fn codel(&mut self, codel: &ModelCodel, told: &[Argument]) -> Agreement {
        if codel.parameters.len() != told.len() {
            let (wanted, found) = (codel.parameters.len(), told.len());
            return Err(Mismatch::Count {
                what: "arguments before the context",
                wanted,
                and: ",",
                takes: "takes",
                found,
            });
        }
        for (rank, (parameter, argument)) in codel.parameters.iter().zip(told).enumerate() {
            self.argument(parameter, argument)
                .map_err(|why| why.within(format!("argument {} `{}`", rank + 1, parameter.name)))?;
        }
        Ok(())
    }

    fn argument(&mut self, parameter: &CodelParameter, told: &Argument) -> Agreement {
        let model = self.plan.component();
        let wanted = match parameter.source {
            Source::Remote(remote) => {
                let remote = model.remotes.get(remote).ok_or(Mismatch::Absent("remote"))?;
                return self.remote(remote, told);
            }
            Source::Port(port) => {
                let port = model.ports.get(port).ok_or(Mismatch::Absent("port"))?;
                match (port.direction, port.multiple) {
                    (PortDirection::In, false) => Passing::IN_PORT,
                    (PortDirection::Out, false) => Passing::OUT_PORT,
                    (PortDirection::In, true) => Passing::MULTIPLE_IN_PORT,
                    (PortDirection::Out, true) => Passing::MULTIPLE_OUT_PORT,
                }
            }
            _ => self.passing(parameter.ty, parameter.direction),
        };
        if told.passing != wanted {
            return Err(Mismatch::other(way(wanted), way(told.passing)));
        }
        let ty = match parameter.source {
            Source::Port(port) => model.ports.get(port).map_or(parameter.ty, |port| port.ty),
            _ => parameter.ty,
        };
        self.ty(ty, told.ty)
    }

    /// How a datum is passed to a codel or a remote (genom3.md 5.5).
    fn passing(&self, ty: TypeId, direction: Direction) -> Passing {
        let kind = self.plan.specification().types.resolved(ty);
        match Class::of(kind, direction) {
            Class::Value(_) | Class::Held => Passing::VALUE,
            Class::Address if direction == Direction::In => Passing::SHARED,
            Class::Address => Passing::EXCLUSIVE,
        }
    }

    /// Compares the parameters of a remote, which are the members of its argument's type.
    fn remote(&mut self, remote: &Remote, told: &Argument) -> Agreement {
        if told.passing != Passing::REMOTE {
            return Err(Mismatch::other(way(Passing::REMOTE), way(told.passing)));
        }
        let table = self.table;
        let Some(told) = told.ty.map(|rank| &table.types[rank]) else {
            return Err(Mismatch::Untold("parameters"));
        };
        let (wanted, found) = (remote.parameters.len(), told.members.len());
        if wanted != found {
            let (what, and, takes) = ("parameters", ",", "has");
            return Err(Mismatch::Count { what, wanted, and, takes, found });
        }
        for (parameter, told) in remote.parameters.iter().zip(&told.members) {
            let place = |why: Mismatch| why.within(format!("parameter `{}`", parameter.name));
            let wanted = self.passing(parameter.ty, parameter.direction);
            // For a parameter, `offset` holds the number of how it is passed.
            let found = u32::try_from(told.offset).map_or(Passing(u32::MAX), Passing);
            if wanted != found {
                return Err(place(Mismatch::other(way(wanted), way(found))));
            }
            self.ty(parameter.ty, told.ty).map_err(place)?;
        }
        Ok(())
    }

    /// Compares two types and all types inside them.
    fn ty(&mut self, id: TypeId, told: Option<usize>) -> Agreement {
        let types = &self.plan.specification().types;
        let id = types.resolve(id);
        let Some(rank) = told else { return Err(Mismatch::Untold("type")) };
        if !self.seen.insert((id, rank)) {
            return Ok(());
        }
        let told = &self.table.types[rank];
        let data = DataType::new(types, id)?;
        let differ = |what, wanted: usize, found: usize| {
            let number = Mismatch::Number { what, wanted: wanted as u64, found: found as u64 };
            Err(number.within(types.spelling(id)))
        };
        let (kind, bound, element) = describe(types.kind(id));
        if told.kind != kind {
            let (wanted, found) = (types.spelling(id), show(self.table, Some(rank)));
            return Err(Mismatch::other(wanted, found));
        }
        if told.bound != bound {
            return differ("bound or length", bound, told.bound);
        }
        if let (Some(name), Some(found)) = (types.kind(id).name(), &told.name)
            && name.to_string() != *found
        {
            return Err(Mismatch::other(name.to_string(), found));
        }
        if told.kind != abi::Kind::NATIVE {
            self.members(id, &data, told)?;
            if told.size != data.size() {
                return differ("size", data.size(), told.size);
            }
            if told.align != data.align() {
                return differ("alignment", data.align(), told.align);
            }
        }
        match element {
            Some(element) => self.ty(element, told.element),
            None => Ok(()),
        }
    }

    /// Compares the members of a struct, or the enumerators of an enum.
    fn members(&mut self, id: TypeId, data: &DataType, told: &Type) -> Agreement {
        let types = &self.plan.specification().types;
        let names = |names: Vec<&str>| names.join(", ");
        let found: Vec<&str> = told.members.iter().map(|member| member.name.as_str()).collect();
        if let Kind::Enum { enumerators, .. } = types.kind(id) {
            let wanted: Vec<&str> = enumerators.iter().map(String::as_str).collect();
            if wanted != found {
                let (wanted, found) = (names(wanted), names(found));
                let other = Mismatch::other(format!("{{ {wanted} }}"), format!("{{ {found} }}"));
                return Err(other.within(data.name()));
            }
            return Ok(());
        }
        let members = types.members(id);
        let wanted: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
        if wanted != found {
            let (wanted, found) = (names(wanted), names(found));
            let others = Mismatch::others(format!("members {wanted}"), found);
            return Err(others.within(data.name()));
        }
        for (rank, (member, told)) in members.iter().zip(&told.members).enumerate() {
            let place = |why: Mismatch| why.within(format!("{}::{}", data.name(), member.name));
            self.ty(member.ty, told.ty).map_err(place)?;
            let offset = data.member_offset(rank).unwrap_or_default();
            if offset != told.offset {
                let (wanted, found) = (offset as u64, told.offset as u64);
                return Err(place(Mismatch::Number { what: "offset", wanted, found }));
            }
        }
        Ok(())
    }
}

/// A kind as the table encodes it: number, bound, element.
fn describe(kind: &Kind) -> (abi::Kind, usize, Option<TypeId>) {
    let plain = |kind| (kind, 0, None);
    match kind {
        Kind::Boolean => plain(abi::Kind::BOOLEAN),
        Kind::Char => plain(abi::Kind::CHAR),
        Kind::Octet => plain(abi::Kind::OCTET),
        Kind::Short => plain(abi::Kind::SHORT),
        Kind::UnsignedShort => plain(abi::Kind::UNSIGNED_SHORT),
        Kind::Long => plain(abi::Kind::LONG),
        Kind::UnsignedLong => plain(abi::Kind::UNSIGNED_LONG),
        Kind::LongLong => plain(abi::Kind::LONG_LONG),
        Kind::UnsignedLongLong => plain(abi::Kind::UNSIGNED_LONG_LONG),
        Kind::Float => plain(abi::Kind::FLOAT),
        Kind::Double => plain(abi::Kind::DOUBLE),
        Kind::String { bound } => (abi::Kind::STRING, bound.unwrap_or(0) as usize, None),
        Kind::Array { element, length } => (abi::Kind::ARRAY, *length as usize, Some(*element)),
        Kind::Sequence { element, bound } => {
            (abi::Kind::SEQUENCE, bound.unwrap_or(0) as usize, Some(*element))
        }
        Kind::Optional { element } => (abi::Kind::OPTIONAL, 0, Some(*element)),
        Kind::Enum { .. } => plain(abi::Kind::ENUM),
        Kind::Struct { .. } => plain(abi::Kind::STRUCT),
        Kind::Union { .. } => plain(abi::Kind::UNION),
        Kind::Exception { .. } => plain(abi::Kind::EXCEPTION),
        Kind::Native { .. } => plain(abi::Kind::NATIVE),
        Kind::Typedef { .. } | Kind::Forward { .. } | Kind::Any => plain(abi::Kind(u32::MAX)),
    }
}

/// How an argument is passed, in words.
fn way(passing: Passing) -> &'static str {
    match passing {
        Passing::VALUE => "a value (`T`, or `&CStr`)",
        Passing::SHARED => "`&T`",
        Passing::EXCLUSIVE => "`&mut T`",
        Passing::IN_PORT => "`InPort`",
        Passing::OUT_PORT => "`OutPort`",
        Passing::MULTIPLE_IN_PORT => "`MultipleInPort`",
        Passing::MULTIPLE_OUT_PORT => "`MultipleOutPort`",
        Passing::REMOTE => "a remote",
        _ => "a way this daemon does not know",
    }
}

fn show_argument(table: &Table, argument: &Argument) -> String {
    let ty = show(table, argument.ty);
    let name = &argument.name;
    match argument.passing {
        Passing::VALUE => format!("{name}: {ty}"),
        Passing::SHARED => format!("{name}: &{ty}"),
        Passing::EXCLUSIVE => format!("{name}: &mut {ty}"),
        Passing::IN_PORT => format!("{name}: &mut InPort<{ty}>"),
        Passing::OUT_PORT => format!("{name}: &mut OutPort<{ty}>"),
        Passing::MULTIPLE_IN_PORT => format!("{name}: &mut MultipleInPort<{ty}>"),
        Passing::MULTIPLE_OUT_PORT => format!("{name}: &mut MultipleOutPort<{ty}>"),
        Passing::REMOTE => format!("{name}: &mut a remote"),
        _ => format!("{name}: ?"),
    }
}

/// A type of the table in IDL.
fn show(table: &Table, rank: Option<usize>) -> String {
    let Some(ty) = rank.map(|rank| &table.types[rank]) else { return "?".to_owned() };
    if let Some(name) = &ty.name {
        return name.clone();
    }
    let element = || match ty.element {
        // A type without a name leads, by its elements, to one with a name or a basic one.
        Some(element) if Some(element) != rank => show(table, Some(element)),
        _ => "?".to_owned(),
    };
    let bound = if ty.bound == 0 { String::new() } else { format!(",{}", ty.bound) };
    match ty.kind {
        abi::Kind::BOOLEAN => "boolean".to_owned(),
        abi::Kind::CHAR => "char".to_owned(),
        abi::Kind::OCTET => "octet".to_owned(),
        abi::Kind::SHORT => "short".to_owned(),
        abi::Kind::UNSIGNED_SHORT => "unsigned short".to_owned(),
        abi::Kind::LONG => "long".to_owned(),
        abi::Kind::UNSIGNED_LONG => "unsigned long".to_owned(),
        abi::Kind::LONG_LONG => "long long".to_owned(),
        abi::Kind::UNSIGNED_LONG_LONG => "unsigned long long".to_owned(),
        abi::Kind::FLOAT => "float".to_owned(),
        abi::Kind::DOUBLE => "double".to_owned(),
        abi::Kind::STRING if ty.bound == 0 => "string".to_owned(),
        abi::Kind::STRING => format!("string<{}>", ty.bound),
        abi::Kind::ARRAY => format!("{}[{}]", element(), ty.bound),
        abi::Kind::SEQUENCE => format!("sequence<{}{bound}>", element()),
        abi::Kind::OPTIONAL => format!("optional<{}>", element()),
        _ => format!("a type of kind {}", ty.kind.0),
    }
}
