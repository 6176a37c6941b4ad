//! A component as data: what `genomctl info` and clients of other languages read.

use std::sync::Arc;

use genom_description::model::{
    Component, Dialect, Direction, Parameter, Port, PortDirection, Service, ServiceKind, Task,
};
use genom_types::{DataType, TypeId, TypeTable};
use serde_json::{Map, Value, json};

/// Describes a whole component, without what depends on the instance.
pub(crate) fn component(types: &Arc<TypeTable>, component: &Component) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("component".into(), component.name.as_str().into());
    out.insert("version".into(), component.version.as_str().into());
    insert_some(&mut out, "doc", component.doc.clone());
    insert_some(&mut out, "email", component.email.clone());
    out.insert("language".into(), component.lang.as_str().into());
    let dialect = match component.dialect {
        Dialect::Paper2010 => "2010",
        Dialect::Paper2011 => "2011",
        Dialect::Current => "current",
    };
    out.insert("dialect".into(), dialect.into());
    out.insert("digest".into(), component.digest.as_str().into());
    let tasks: Vec<_> = component.tasks.iter().map(task).collect();
    out.insert("tasks".into(), tasks.into());
    let ports: Vec<_> = component.ports.iter().map(|found| port(types, found)).collect();
    out.insert("ports".into(), ports.into());
    let remotes: Vec<_> = component
        .remotes
        .iter()
        .map(|remote| json!({"name": remote.name, "interface": remote.interface}))
        .collect();
    out.insert("remotes".into(), remotes.into());
    let services: Vec<_> =
        component.services.iter().map(|found| service(types, component, found)).collect();
    out.insert("services".into(), services.into());
    let events: Vec<_> = component.sinks.iter().map(|sink| sink.name.as_str()).collect();
    out.insert("events".into(), json!(events));
    out
}

/// Describes a service: what it takes, gives and throws.
pub(crate) fn service(types: &Arc<TypeTable>, component: &Component, service: &Service) -> Value {
    let kind = match service.kind {
        ServiceKind::Attribute => "attribute",
        ServiceKind::Function => "function",
        ServiceKind::Activity => "activity",
    };
    let mut out = Map::new();
    out.insert("name".into(), service.name.as_str().into());
    out.insert("kind".into(), kind.into());
    insert_some(&mut out, "doc", service.doc.clone());
    let task = service.task.and_then(|index| component.tasks.get(index));
    insert_some(&mut out, "task", task.map(|task| task.name.clone()));
    let parameters: Vec<_> =
        service.parameters.iter().map(|found| parameter(types, found)).collect();
    out.insert("parameters".into(), parameters.into());
    let throws: Vec<_> = service.throws.iter().map(|&id| type_name(types, id)).collect();
    out.insert("throws".into(), json!(throws));
    for (word, indices) in [
        ("interrupts", &service.interrupts),
        ("before", &service.before),
        ("after", &service.after),
    ] {
        let names: Vec<_> = indices
            .iter()
            .filter_map(|&index| component.services.get(index))
            .map(|service| service.name.as_str())
            .collect();
        if !names.is_empty() {
            out.insert(word.into(), json!(names));
        }
    }
    out.insert("digest".into(), service.digest.as_str().into());
    if service.standard {
        out.insert("standard".into(), true.into());
    }
    Value::Object(out)
}

fn parameter(types: &Arc<TypeTable>, parameter: &Parameter) -> Value {
    let direction = match parameter.direction {
        Direction::In => "in",
        Direction::Out => "out",
        Direction::InOut => "inout",
    };
    let mut out = Map::new();
    out.insert("name".into(), parameter.name.as_str().into());
    out.insert("direction".into(), direction.into());
    out.insert("type".into(), type_name(types, parameter.ty).into());
    if let Some(default) = &parameter.default {
        insert_some(&mut out, "default", default.value.clone());
        insert_some(&mut out, "doc", default.doc.clone());
        if !default.member_docs.is_empty() {
            let docs: Map<_, _> =
                default.member_docs.iter().map(|(at, doc)| (at.clone(), json!(doc))).collect();
            out.insert("member_docs".into(), docs.into());
        }
    }
    Value::Object(out)
}

/// Describes a port.
pub(crate) fn port(types: &Arc<TypeTable>, port: &Port) -> Value {
    let mut out = Map::new();
    out.insert("name".into(), port.name.as_str().into());
    out.insert("direction".into(), direction(port.direction).into());
    out.insert("multiple".into(), port.multiple.into());
    out.insert("type".into(), type_name(types, port.ty).into());
    insert_some(&mut out, "doc", port.doc.clone());
    Value::Object(out)
}

/// `in` or `out`.
pub(crate) fn direction(direction: PortDirection) -> &'static str {
    match direction {
        PortDirection::In => "in",
        PortDirection::Out => "out",
    }
}

fn task(task: &Task) -> Value {
    let mut out = Map::new();
    out.insert("name".into(), task.name.as_str().into());
    insert_some(&mut out, "doc", task.doc.clone());
    insert_some(&mut out, "period", task.period.map(|period| period.as_secs_f64()));
    insert_some(&mut out, "priority", task.priority);
    Value::Object(out)
}

/// The IDL spelling of a type.
pub(crate) fn type_name(types: &Arc<TypeTable>, id: TypeId) -> String {
    match types.kind(id).name() {
        Some(name) => name.to_string(),
        None => DataType::new(types, id)
            .map_or_else(|_| "?".to_owned(), |found| found.name().to_owned()),
    }
}

fn insert_some(out: &mut Map<String, Value>, key: &str, value: Option<impl Into<Value>>) {
    if let Some(value) = value {
        out.insert(key.to_owned(), value.into());
    }
}
