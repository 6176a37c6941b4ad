//! Events, ports, remotes and codel prototypes of a component (genom3.md 5.3, 5.6 to 5.8).

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::c_names::event_names;
use genom_description::model::{Codel, Component, Direction, Owner, PortDirection, Source};
use genom_types::TypeTable;

use super::declare::{Passing, argument, data_method, parameter};
use super::guard::guarded;

/// Writes a weak definition for each state, and for each pause that a codel yields.
pub(super) fn events(out: &mut String, component: &Component) {
    for (symbol, text) in event_names(component) {
        guarded(out, &symbol, &format!("GENOM_EVENT({symbol}, \"{text}\");"));
    }
}

/// Writes the handle of each port: a struct of functions that the host supplies.
pub(super) fn ports(out: &mut String, types: &TypeTable, component: &Component) {
    for port in &component.ports {
        let tag = format!("{}_{}", component.name, port.name);
        let id = if port.multiple { "const char *id, " } else { "" };
        let arguments = format!("{id}genom_context self");
        let mut body = format!("  {};\n", data_method(types, port.ty, &arguments));
        let methods: &[&str] = match (port.direction, port.multiple) {
            (PortDirection::In, _) => &["read"],
            (PortDirection::Out, false) => &["write"],
            (PortDirection::Out, true) => &["write", "open", "close"],
        };
        for method in methods {
            let _ = writeln!(body, "  genom_event (*{method})({arguments});");
        }
        guarded(out, &tag, &format!("typedef struct {tag} {{\n{body}}} {tag};"));
        // Prototypes of GenoM3 2.99.41 name the interface that the port comes from.
        if let Some(interface) = port.interface.as_ref().filter(|name| *name != "genom") {
            let also = format!("{interface}_{}", port.name);
            guarded(out, &also, &format!("typedef {tag} {also};"));
        }
    }
}

/// Writes the handle of each remote: a function that calls the service and waits for its end.
pub(super) fn remotes(out: &mut String, types: &TypeTable, component: &Component) {
    for remote in &component.remotes {
        let tag = format!("{}_{}", component.name, remote.name);
        let mut list: Vec<_> = remote
            .parameters
            .iter()
            .map(|p| parameter(types, p.ty, passing(p.direction), &argument(&p.name)))
            .collect();
        list.push("genom_context self".to_owned());
        let body = format!("  genom_event (*call)({});\n", list.join(", "));
        guarded(out, &tag, &format!("typedef struct {tag} {{\n{body}}} {tag};"));
    }
}

/// Writes one prototype for each C function, except those that the host supplies.
pub(super) fn codels(out: &mut String, types: &TypeTable, chosen: &[&Component]) {
    let mut written = HashSet::new();
    for component in chosen {
        let _ = writeln!(out, "/* Codels of {}. */", component.name);
        for codel in component.codels.iter().filter(|codel| !is_standard(component, codel)) {
            if written.insert(codel.name.as_str()) {
                let _ = writeln!(out, "{};", prototype(types, component, codel));
            }
        }
        out.push('\n');
    }
}

/// `genom_event f(int32_t a, const genom_context self)`.
pub(super) fn prototype(types: &TypeTable, component: &Component, codel: &Codel) -> String {
    format!("genom_event {}({})", codel.name, arguments(types, component, codel).join(", "))
}

pub(super) fn is_standard(component: &Component, codel: &Codel) -> bool {
    match codel.owner {
        Owner::Service(rank) => component.services.get(rank).is_some_and(|s| s.standard),
        Owner::Task(_) => false,
    }
}

fn arguments(types: &TypeTable, component: &Component, codel: &Codel) -> Vec<String> {
    let mut list = Vec::new();
    for (name, source) in names(codel) {
        let Some(from) = codel.parameters.get(list.len()) else { break };
        list.push(match source {
            Source::Port(rank) => {
                let port = component.ports.get(*rank).map_or("", |port| port.name.as_str());
                format!("const {}_{port} *{name}", component.name)
            }
            Source::Remote(rank) => {
                let remote = component.remotes.get(*rank).map_or("", |r| r.name.as_str());
                format!("const {}_{remote} *{name}", component.name)
            }
            _ => parameter(types, from.ty, passing(from.direction), &name),
        });
    }
    list.push("const genom_context self".to_owned());
    list
}

/// A C name for each parameter. In the papers' dialects a port and an IDS member may have the same
/// name: the port gets the suffix `_port` (dialects.md, C signatures).
pub(super) fn names(codel: &Codel) -> Vec<(String, &Source)> {
    let mut taken: HashSet<String> = HashSet::new();
    let ports = |source: &Source| matches!(source, Source::Port(_));
    let others: HashSet<&str> =
        codel.parameters.iter().filter(|p| !ports(&p.source)).map(|p| p.name.as_str()).collect();
    let mut names = Vec::new();
    for parameter in &codel.parameters {
        let mut name = argument(&parameter.name);
        if ports(&parameter.source) && others.contains(parameter.name.as_str()) {
            name.push_str("_port");
        }
        while !taken.insert(name.clone()) {
            name.push('_');
        }
        names.push((name, &parameter.source));
    }
    names
}

pub(super) fn passing(direction: Direction) -> Passing {
    match direction {
        Direction::In => Passing::Value,
        Direction::Out | Direction::InOut => Passing::Reference,
    }
}
