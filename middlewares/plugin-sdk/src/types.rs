//! Ports, services and reports as the table describes them.

use std::slice;

use genom_middleware::{
    Address, Diagnosis, Health, LogEntry, LogLevel, Part, Policy, Quality, ServiceKind, ServiceType,
};
use genom_plugin_abi::lent::copied;
use genom_plugin_abi::table::{health, level, part};
use genom_plugin_abi::{Code, Entry, Failure, Pair, Port, Service, Str, Type, table};
use genom_types::{DataType, Definition};

/// # Safety
/// The host lent it for this call.
pub(crate) unsafe fn address(at: table::Address) -> Address {
    // SAFETY: the strings are lent, too.
    let (instance, name) = unsafe { (at.instance.read(), at.name.read()) };
    Address::new(instance, name)
}

fn incomplete(what: &str) -> Failure {
    Failure::new(Code::FAILED, format!("the host describes no {what}"))
}

/// # Safety
/// The host lent it for this call.
unsafe fn data_type(ty: *const Type) -> Result<DataType, Failure> {
    // SAFETY: it begins with its size; zero is a value of all its members.
    let ty = unsafe { copied(ty) }.ok_or_else(|| incomplete("type"))?;
    // SAFETY: lent for this call.
    let definition = unsafe { ty.definition.read() };
    let wrong = |why: String| Failure::new(Code::FAILED, format!("the host's type: {why}"));
    let definition: Definition =
        serde_json::from_str(&definition).map_err(|error| wrong(error.to_string()))?;
    definition.read().map_err(|error| wrong(error.to_string()))
}

/// A port that is to be opened.
pub(crate) struct Wanted {
    pub(crate) at: Address,
    pub(crate) ty: DataType,
    pub(crate) quality: Quality,
    pub(crate) policy: Policy,
}

/// # Safety
/// The host lent it for this call.
pub(crate) unsafe fn port(port: *const Port) -> Result<Wanted, Failure> {
    // SAFETY: it begins with its size; zero is a value of all its members.
    let port = unsafe { copied(port) }.ok_or_else(|| incomplete("port"))?;
    let choice = |value: i32| (value >= 0).then_some(value > 0);
    let quality = Quality {
        reliable: choice(port.reliable),
        depth: usize::try_from(port.depth).ok(),
        transient_local: choice(port.transient_local),
    };
    let keep = port.keep as usize;
    let policy = match port.policy {
        table::policy::QUEUE => Policy::Queue(keep),
        table::policy::RING => Policy::Ring(keep),
        _ => Policy::Latest,
    };
    // SAFETY: what it points to is lent, too.
    let (at, ty) = unsafe { (address(port.at), data_type(port.ty)?) };
    Ok(Wanted { at, ty, quality, policy })
}

/// # Safety
/// The host lent it for this call.
pub(crate) unsafe fn service(service: *const Service) -> Result<ServiceType, Failure> {
    // SAFETY: it begins with its size; zero is a value of all its members.
    let service = unsafe { copied(service) }.ok_or_else(|| incomplete("service"))?;
    let kind = match service.kind {
        table::service::ATTRIBUTE => ServiceKind::Attribute,
        table::service::ACTIVITY => ServiceKind::Activity,
        _ => ServiceKind::Function,
    };
    // SAFETY: what it points to is lent, too.
    let (input, output) = unsafe { (data_type(service.input)?, data_type(service.output)?) };
    // SAFETY: as above.
    let described = unsafe { service.described.read() };
    Ok(ServiceType::new(kind, input, output).described(described))
}

/// # Safety
/// The host lent it for this call.
pub(crate) unsafe fn entry(entry: *const Entry) -> Option<LogEntry> {
    // SAFETY: it begins with its size; zero is a value of all its members.
    let entry = unsafe { copied(entry) }?;
    // SAFETY: the strings are lent, too.
    let text = |text: Str| unsafe { text.read() }.into_owned();
    Some(LogEntry {
        instance: text(entry.instance),
        time: entry.time,
        level: match entry.level {
            level::ERROR => LogLevel::Error,
            level::WARN => LogLevel::Warn,
            level::INFO => LogLevel::Info,
            _ => LogLevel::Debug,
        },
        place: text(entry.place),
        file: text(entry.file),
        line: entry.line,
        message: text(entry.message),
    })
}

/// # Safety
/// `from` is null, or has that many elements, which the host lent.
unsafe fn all<'a, T>(from: *const T, count: usize) -> &'a [T] {
    if from.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: not null; the caller vouches for the rest.
    unsafe { slice::from_raw_parts(from, count) }
}

/// What is of a kind that is not known here is left out.
///
/// # Safety
/// The host lent that many for this call.
pub(crate) unsafe fn parts(from: *const *const table::Diagnosis, count: usize) -> Vec<Diagnosis> {
    // SAFETY: as for this function.
    let each = unsafe { all(from, count) }.iter();
    // SAFETY: as above.
    each.filter_map(|one| unsafe { diagnosis(*one) }).collect()
}

/// # Safety
/// The host lent it for this call.
unsafe fn diagnosis(from: *const table::Diagnosis) -> Option<Diagnosis> {
    // SAFETY: it begins with its size; zero is a value of all its members.
    let from = unsafe { copied(from) }?;
    // SAFETY: the strings are lent, too.
    let text = |text: Str| unsafe { text.read() }.into_owned();
    // SAFETY: and so are the values.
    let values = unsafe { all::<Pair>(from.values, from.count) };
    Some(Diagnosis {
        instance: text(from.instance),
        of: match from.part {
            part::TASK => Part::Task(text(from.name)),
            part::CELL => Part::Cell(text(from.name)),
            _ => return None,
        },
        health: match from.health {
            health::GOOD => Health::Good,
            health::LATE => Health::Late,
            health::STUCK => Health::Stuck,
            health::ENDED => Health::Ended,
            _ => return None,
        },
        message: text(from.message),
        values: values.iter().map(|pair| (text(pair.name), text(pair.value))).collect(),
    })
}
