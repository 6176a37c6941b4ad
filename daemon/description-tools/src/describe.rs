//! A component as JSON, and as a page of text.

use std::fmt::Write;
use std::time::Duration;

use genom_types::{Kind, TypeId, TypeTable};
use serde_json::{Value, json};

use genom_description::model::{
    Codel, CodelIx, CodelKind, Component, Dialect, Direction, Parameter, PathStep, Service,
    ServiceIx, ServiceKind, Source, Specification, StateIx,
};

/// The whole component as JSON: services, ports, tasks, types, docs and defaults.
#[must_use]
pub fn describe(spec: &Specification, component: &Component) -> Value {
    let types = &spec.types;
    let tasks = component.tasks.iter().map(|task| {
        json!({
            "name": task.name,
            "doc": task.doc,
            "period": seconds(task.period),
            "delay": task.delay.as_secs_f64(),
            "priority": task.priority,
            "real_time": task.real_time,
            "stack": task.stack,
            "codels": codels(component, types, &task.codels),
            "throws": names(types, &task.throws),
        })
    });
    let ports = component.ports.iter().map(|port| {
        json!({
            "name": port.name,
            "direction": port.direction.as_str(),
            "multiple": port.multiple,
            "type": types.spelling(port.ty),
            "doc": port.doc,
        })
    });
    let remotes = component.remotes.iter().map(|remote| {
        json!({
            "name": remote.name,
            "interface": remote.interface,
            "parameters": parameters(types, &remote.parameters),
            "throws": names(types, &remote.throws),
            "digest": remote.digest,
        })
    });
    let services = component.services.iter().map(|service| one_service(component, types, service));
    let sinks = component.sinks.iter().map(|sink| json!(sink.name));
    json!({
        "name": component.name,
        "dialect": dialect(component.dialect),
        "doc": component.doc,
        "version": component.version,
        "lang": component.lang,
        "email": component.email,
        "requires": component.requires,
        "codels_requires": component.codels_requires,
        "clock_rate": seconds(component.clock_rate),
        "ids": component.ids.map(|ids| members(types, ids)),
        "tasks": tasks.collect::<Vec<_>>(),
        "ports": ports.collect::<Vec<_>>(),
        "remotes": remotes.collect::<Vec<_>>(),
        "services": services.collect::<Vec<_>>(),
        "states": *component.states,
        "events": sinks.collect::<Vec<_>>(),
        "throws": names(types, &component.throws),
        "digest": component.digest,
    })
}

fn one_service(component: &Component, types: &TypeTable, service: &Service) -> Value {
    let services = |places: &[ServiceIx]| -> Vec<&str> {
        let found = places.iter().filter_map(|ix| component.services.get(*ix));
        found.map(|service| service.name.as_str()).collect()
    };
    let task = service.task.and_then(|rank| component.tasks.get(rank));
    json!({
        "name": service.name,
        "kind": kind(service.kind),
        "standard": service.standard,
        "doc": service.doc,
        "parameters": parameters(types, &service.parameters),
        "locals": parameters(types, &service.locals),
        "task": task.map(|task| &task.name),
        "interrupts": services(&service.interrupts),
        "before": services(&service.before),
        "after": services(&service.after),
        "validates": codels(component, types, &service.validates),
        "codels": codels(component, types, &service.codels),
        "throws": names(types, &service.throws),
        "digest": service.digest,
        "call_digest": service.call_digest,
    })
}

fn parameters(types: &TypeTable, list: &[Parameter]) -> Value {
    let one = |parameter: &Parameter| {
        let default = parameter.default.as_ref();
        json!({
            "name": parameter.name,
            "direction": direction(parameter.direction),
            "type": types.spelling(parameter.ty),
            "default": default.and_then(|default| default.value.clone()),
            "doc": default.and_then(|default| default.doc.clone()),
        })
    };
    list.iter().map(one).collect()
}

fn codels(component: &Component, types: &TypeTable, list: &[CodelIx]) -> Value {
    list.iter()
        .filter_map(|ix| component.codels.get(*ix))
        .map(|codel| one_codel(component, types, codel))
        .collect()
}

fn one_codel(component: &Component, types: &TypeTable, codel: &Codel) -> Value {
    let state = |ix: StateIx| component.states.get(ix).map_or("?", String::as_str);
    let (on, yields) = match &codel.kind {
        CodelKind::Fsm { triggers, yields } => {
            let on: Vec<_> = triggers.iter().map(|ix| state(*ix)).collect();
            let pause = |to: bool| if to { "pause::" } else { "" };
            let to = yields.iter().map(|to| format!("{}{}", pause(to.pause), state(to.state)));
            (Some(on), Some(to.collect::<Vec<_>>()))
        }
        _ => (None, None),
    };
    let one = |parameter: &genom_description::model::CodelParameter| {
        json!({
            "name": parameter.name,
            "direction": direction(parameter.direction),
            "type": types.spelling(parameter.ty),
            "source": source(component, types, &parameter.source),
        })
    };
    json!({
        "name": codel.name,
        "async": codel.asynchronous,
        "on": on,
        "yields": yields,
        "parameters": codel.parameters.iter().map(one).collect::<Vec<_>>(),
        "wcet": seconds(codel.wcet),
    })
}

/// The source of an argument, as written in a description: `ids a.b[2]`, `port p`.
fn source(component: &Component, types: &TypeTable, source: &Source) -> String {
    match source {
        Source::Ids { path } => {
            let path = component.ids.map(|ids| spell_path(types, ids, path)).unwrap_or_default();
            format!("ids {}", path.trim_start_matches('.')).trim_end().to_owned()
        }
        Source::Parameter { .. } | Source::Local { .. } => "local".to_owned(),
        Source::Port(rank) => {
            format!("port {}", component.ports.get(*rank).map_or("?", |port| &port.name))
        }
        Source::Remote(rank) => {
            format!("remote {}", component.remotes.get(*rank).map_or("?", |remote| &remote.name))
        }
    }
}

fn spell_path(types: &TypeTable, root: TypeId, path: &[PathStep]) -> String {
    let mut out = String::new();
    let mut at = root;
    for step in path {
        while let Kind::Optional { element } = types.resolved(at) {
            at = *element;
        }
        match (step, types.resolved(at)) {
            (PathStep::Member(rank), Kind::Union { members, .. }) => {
                let Some(member) = members.get(*rank) else { break };
                let _ = write!(out, ".{}", member.name);
                at = member.ty;
            }
            (PathStep::Member(rank), _) => {
                let Some(member) = types.members(at).get(*rank) else { break };
                let _ = write!(out, ".{}", member.name);
                at = member.ty;
            }
            (
                PathStep::Index(index),
                Kind::Array { element, .. } | Kind::Sequence { element, .. },
            ) => {
                let _ = write!(out, "[{index}]");
                at = *element;
            }
            (PathStep::Index(_), _) => break,
        }
    }
    out
}

fn members(types: &TypeTable, id: TypeId) -> Value {
    let one = |member: &genom_types::Member| json!({ "name": member.name, "type": types.spelling(member.ty) });
    types.members(id).iter().map(one).collect()
}

fn names(types: &TypeTable, list: &[TypeId]) -> Vec<String> {
    list.iter().map(|id| types.spelling(*id)).collect()
}

fn seconds(time: Option<Duration>) -> Option<f64> {
    time.map(|time| time.as_secs_f64())
}

fn direction(direction: Direction) -> &'static str {
    match direction {
        Direction::In => "in",
        Direction::Out => "out",
        Direction::InOut => "inout",
    }
}

fn kind(kind: ServiceKind) -> &'static str {
    match kind {
        ServiceKind::Attribute => "attribute",
        ServiceKind::Function => "function",
        ServiceKind::Activity => "activity",
    }
}

fn dialect(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::Paper2010 => "2010",
        Dialect::Paper2011 => "2011",
        Dialect::Current => "current",
    }
}

/// The component as text for people: one line for each item, with its doc.
#[must_use]
pub fn describe_text(spec: &Specification, component: &Component) -> String {
    let types = &spec.types;
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "component {} {}", component.name, component.version);
    if let Some(doc) = &component.doc {
        let _ = writeln!(out, "  {}", doc.replace('\n', "\n  "));
    }
    if component.dialect != Dialect::Current {
        let _ = writeln!(out, "  written in the language of {}", dialect(component.dialect));
    }
    let mut section = |title: &str, lines: Vec<(String, Option<&String>)>| {
        if lines.is_empty() {
            return;
        }
        let _ = writeln!(out, "\n{title}");
        let width = lines.iter().map(|(line, _)| line.chars().count()).max().unwrap_or(0).min(60);
        for (line, doc) in lines {
            let doc = doc.map(|doc| doc.lines().next().unwrap_or_default()).unwrap_or_default();
            let line = format!("  {line:width$}  {doc}");
            let _ = writeln!(out, "{}", line.trim_end());
        }
    };
    let tasks = component.tasks.iter().map(|task| {
        let pace = task.period.map_or_else(|| "aperiodic".to_owned(), |p| format!("every {p:?}"));
        (format!("{} {pace}", task.name), task.doc.as_ref())
    });
    section("tasks", tasks.collect());
    let ports = component.ports.iter().map(|port| {
        let multiple = if port.multiple { "multiple " } else { "" };
        let (way, ty) = (port.direction.as_str(), types.spelling(port.ty));
        (format!("{multiple}{way} {}: {ty}", port.name), port.doc.as_ref())
    });
    section("ports", ports.collect());
    for (wanted, title) in [
        (ServiceKind::Attribute, "attributes"),
        (ServiceKind::Function, "functions"),
        (ServiceKind::Activity, "activities"),
    ] {
        let services = component.services.iter().filter(|service| service.kind == wanted);
        let lines = services.map(|service| {
            (signature(types, &service.name, &service.parameters), service.doc.as_ref())
        });
        section(title, lines.collect());
    }
    let remotes = component.remotes.iter().map(|remote| {
        let signature = signature(types, &remote.name, &remote.parameters);
        (format!("{signature} of {}", remote.interface), None)
    });
    section("remotes", remotes.collect());
    let throws = names(types, &component.throws);
    section("exceptions", throws.into_iter().map(|name| (name, None)).collect());
    let _ = writeln!(out, "\ndigest {}", component.digest);
    out
}

fn signature(types: &TypeTable, name: &str, list: &[Parameter]) -> String {
    let one = |parameter: &Parameter| {
        let default = parameter.default.as_ref().and_then(|default| default.value.as_ref());
        let default = default.map(|value| format!(" = {value}")).unwrap_or_default();
        let (way, ty) = (direction(parameter.direction), types.spelling(parameter.ty));
        format!("{way} {}: {ty}{default}", parameter.name)
    };
    format!("{name}({})", list.iter().map(one).collect::<Vec<_>>().join(", "))
}
