//! Types, ports and services as a library reads them. What is described here is lent from it.

use genom_middleware::describe::{type_of_port, types_of_service};
use genom_middleware::{
    Address, Diagnosis, Health, LogEntry, LogLevel, Part, Policy, PortSpec, ServiceKind,
    ServiceType,
};
use genom_plugin_abi::table::{self, FIXED_SIZE, health, level, part, policy, service};
use genom_plugin_abi::{Entry, Pair, Port, Service, Sides, Str, Type};
use genom_types::{DataType, Definition};

/// An address, lent.
pub(crate) fn address(at: &Address) -> table::Address {
    table::Address { instance: Str::of(&at.instance), name: Str::of(&at.name) }
}

/// The definition of a type in JSON.
fn definition(ty: &DataType) -> String {
    // A definition has nothing that JSON cannot hold.
    serde_json::to_string(&Definition::of(ty)).unwrap_or_default()
}

fn data_type(ty: &DataType, definition: &str) -> Type {
    Type {
        size: size_of::<Type>(),
        name: Str::of(ty.name()),
        digest: Str::of(ty.digest()),
        definition: Str::of(definition),
        bytes: ty.size() as u64,
        align: u32::try_from(ty.align()).unwrap_or_default(),
        flags: if ty.is_fixed_size() { FIXED_SIZE } else { 0 },
    }
}

/// Passes a port on as a structure that is lent.
pub(crate) fn with_port<R>(
    port: &PortSpec<'_>,
    kept: Policy,
    to: impl FnOnce(*const Port) -> R,
) -> R {
    let definition = definition(port.ty);
    let ty = data_type(port.ty, &definition);
    let choice = |choice: Option<bool>| choice.map_or(-1, i32::from);
    let (policy, keep) = match kept {
        Policy::Latest => (policy::LATEST, 1),
        Policy::Queue(keep) => (policy::QUEUE, keep),
        Policy::Ring(keep) => (policy::RING, keep),
    };
    to(&Port {
        size: size_of::<Port>(),
        at: address(port.address),
        ty: &ty,
        reliable: choice(port.quality.reliable),
        transient_local: choice(port.quality.transient_local),
        depth: port.quality.depth.and_then(|depth| i64::try_from(depth).ok()).unwrap_or(-1),
        policy,
        keep: u32::try_from(keep).unwrap_or(u32::MAX),
    })
}

/// Passes a service on as a structure that is lent.
pub(crate) fn with_service<R>(ty: &ServiceType, to: impl FnOnce(*const Service) -> R) -> R {
    let (input, output) = (definition(&ty.input), definition(&ty.output));
    let (input, output) = (data_type(&ty.input, &input), data_type(&ty.output, &output));
    let digest = ty.digest();
    to(&Service {
        size: size_of::<Service>(),
        kind: match ty.kind {
            ServiceKind::Attribute => service::ATTRIBUTE,
            ServiceKind::Function => service::FUNCTION,
            ServiceKind::Activity => service::ACTIVITY,
        },
        input: &input,
        output: &output,
        digest: Str::of(&digest),
        described: Str::of(&ty.described),
    })
}

/// What errors say of a port.
pub(crate) fn sides_of_port(backend: &str, port: &PortSpec<'_>) -> Sides {
    Sides {
        backend: backend.to_owned(),
        address: port.address.clone(),
        name: port.ty.name().to_owned(),
        ours: type_of_port(port.ty),
    }
}

/// What errors say of a service.
pub(crate) fn sides_of_service(backend: &str, at: &Address, service: &ServiceType) -> Sides {
    Sides {
        backend: backend.to_owned(),
        address: at.clone(),
        name: service.input.name().to_owned(),
        ours: types_of_service(service),
    }
}

/// Passes an entry of a log on as a structure that is lent.
pub(crate) fn with_entry(entry: &LogEntry, to: impl FnOnce(&Entry)) {
    to(&Entry {
        size: size_of::<Entry>(),
        instance: Str::of(&entry.instance),
        time: entry.time,
        level: match entry.level {
            LogLevel::Error => level::ERROR,
            LogLevel::Warn => level::WARN,
            LogLevel::Info => level::INFO,
            LogLevel::Debug => level::DEBUG,
        },
        line: entry.line,
        place: Str::of(&entry.place),
        file: Str::of(&entry.file),
        message: Str::of(&entry.message),
    });
}

/// Passes on how parts of components fare, as structures that are lent.
pub(crate) fn with_parts(parts: &[Diagnosis], to: impl FnOnce(&[*const table::Diagnosis])) {
    let pair =
        |(name, value): &(String, String)| Pair { name: Str::of(name), value: Str::of(value) };
    let values: Vec<Vec<Pair>> =
        parts.iter().map(|part| part.values.iter().map(pair).collect()).collect();
    let lent: Vec<_> = parts.iter().zip(&values).map(|(part, values)| lent(part, values)).collect();
    let pointers: Vec<*const table::Diagnosis> = lent.iter().map(std::ptr::from_ref).collect();
    to(&pointers);
}

fn lent(diagnosis: &Diagnosis, values: &[Pair]) -> table::Diagnosis {
    let (part, name) = match &diagnosis.of {
        Part::Task(name) => (part::TASK, name),
        Part::Cell(name) => (part::CELL, name),
    };
    table::Diagnosis {
        size: size_of::<table::Diagnosis>(),
        instance: Str::of(&diagnosis.instance),
        part,
        health: match diagnosis.health {
            Health::Good => health::GOOD,
            Health::Late => health::LATE,
            Health::Stuck => health::STUCK,
            Health::Ended => health::ENDED,
        },
        name: Str::of(name),
        message: Str::of(&diagnosis.message),
        values: values.as_ptr(),
        count: values.len(),
    }
}
