//! Types of services of a component `demo`.

#![allow(dead_code, reason = "no test uses all of them")]

use std::sync::Arc;

use genom_middleware::{ServiceKind, ServiceType};
use genom_types::{DataType, Kind, Member, ScopedName, TypeId, TypeTable};

/// Makes the type of a member.
pub(crate) type Make = fn(&mut TypeTable) -> TypeId;

pub(crate) const BOOLEAN: Make = |table| table.add(Kind::Boolean);
pub(crate) const SHORT: Make = |table| table.add(Kind::Short);
pub(crate) const LONG: Make = |table| table.add(Kind::Long);
pub(crate) const DOUBLE: Make = |table| table.add(Kind::Double);
/// At most 64 numbers.
pub(crate) const LONGS: Make = |table| {
    let element = table.add(Kind::Long);
    table.add(Kind::Sequence { element, bound: Some(64) })
};

/// `::demo::SERVICE::input` or `output`.
pub(crate) fn part(service: &str, part: &str, members: &[(&str, Make)]) -> DataType {
    let mut table = TypeTable::default();
    let member =
        |(name, make): &(&str, Make)| Member { name: (*name).to_owned(), ty: make(&mut table) };
    let members = members.iter().map(member).collect();
    let name = ScopedName::new(["demo", service, part]);
    let id = table.add(Kind::Struct { name, members });
    DataType::new(&Arc::new(table), id).unwrap()
}

pub(crate) fn service(
    kind: ServiceKind,
    name: &str,
    input: &[(&str, Make)],
    output: &[(&str, Make)],
) -> ServiceType {
    ServiceType::new(kind, part(name, "input", input), part(name, "output", output))
}

/// May be a `std_srvs/srv/Trigger`.
pub(crate) fn reset() -> ServiceType {
    service(ServiceKind::Function, "reset", &[], &[])
}

/// May be a `test_msgs/action/Fibonacci`.
pub(crate) fn count() -> ServiceType {
    service(ServiceKind::Activity, "count", &[("most", LONG)], &[("numbers", LONGS)])
}
