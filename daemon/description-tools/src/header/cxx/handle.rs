//! Events, ports, remotes and codel prototypes in C++ (genom3.md 6).

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::c_names::paused;
use genom_description::model::{Codel, Component, PortDirection, Source};
use genom_types::{ScopedName, TypeTable};

use super::super::declare::argument;
use super::super::handle::{is_standard, names, passing};
use super::declare::{declare, parameter};
use super::guard::{guarded, scoped};

/// Writes a weak definition for each state, and for each pause that a codel yields.
pub(super) fn events(out: &mut String, component: &Component) {
    let name = &component.name;
    for state in &component.states {
        let symbol = argument(state);
        let text = format!("GENOM_CXX_EVENT({symbol}, \"::{name}::{state}\");");
        scoped(out, &ScopedName::new([name.as_str(), state]), &text);
    }
    for state in paused(component).into_iter().filter_map(|rank| component.states.get(rank)) {
        let symbol = argument(state);
        let text = format!("GENOM_CXX_EVENT({symbol}, \"::{name}::pause::{state}\");");
        let namespace = [name.clone(), "pause".to_owned()];
        guarded(out, &format!("{name}_pause_{state}"), &namespace, &text);
    }
}

/// Writes each port as an abstract struct that the host implements.
pub(super) fn ports(out: &mut String, types: &TypeTable, component: &Component) {
    for port in &component.ports {
        let id = if port.multiple { "const char *id" } else { "" };
        let data = declare(types, port.ty, &format!("&data({id}) const = 0;"));
        let (constant, methods): (_, &[&str]) = match (port.direction, port.multiple) {
            (PortDirection::In, _) => ("const ", &["read"]),
            (PortDirection::Out, false) => ("", &["write"]),
            (PortDirection::Out, true) => ("", &["write", "open", "close"]),
        };
        let methods: String =
            methods.iter().map(|name| format!("  virtual void {name}({id}) = 0;\n")).collect();
        let text = format!("struct {} {{\n  virtual {constant}{data}\n{methods}}};", port.name);
        scoped(out, &ScopedName::new([&component.name, &port.name]), &text);
    }
}

/// Writes each remote as a function that calls the service and waits for its end.
pub(super) fn remotes(out: &mut String, types: &TypeTable, component: &Component) {
    for remote in &component.remotes {
        let list: Vec<_> = remote
            .parameters
            .iter()
            .map(|p| parameter(types, p.ty, passing(p.direction), &argument(&p.name)))
            .collect();
        let text = format!(
            "struct {} {{\n  virtual void call({}) = 0;\n}};",
            remote.name,
            list.join(", ")
        );
        scoped(out, &ScopedName::new([&component.name, &remote.name]), &text);
    }
}

/// Writes one prototype for each function, except those that the host supplies. They have default
/// visibility, whatever the flags the codels are compiled with.
pub(super) fn codels(out: &mut String, types: &TypeTable, chosen: &[&Component]) {
    let mut written = HashSet::new();
    out.push_str("#pragma GCC visibility push(default)\n");
    for component in chosen {
        let _ = writeln!(out, "/* Codels of {}. */", component.name);
        for codel in component.codels.iter().filter(|codel| !is_standard(component, codel)) {
            let text = prototype(types, component, codel);
            if written.insert(text.clone()) {
                let _ = writeln!(out, "{text};");
            }
        }
    }
    out.push_str("#pragma GCC visibility pop\n\n");
}

/// `genom::event f(int32_t a, const std::string &b)`.
pub(super) fn prototype(types: &TypeTable, component: &Component, codel: &Codel) -> String {
    let argument =
        |(from, (name, source)): (&genom_description::model::CodelParameter, (String, &Source))| {
            let object = match source {
                Source::Port(rank) => component.ports.get(*rank).map(|port| &port.name),
                Source::Remote(rank) => component.remotes.get(*rank).map(|remote| &remote.name),
                _ => return parameter(types, from.ty, passing(from.direction), &name),
            };
            let object = object.map_or("", String::as_str);
            format!("{}::{object} &{name}", component.name)
        };
    let list: Vec<_> = codel.parameters.iter().zip(names(codel)).map(argument).collect();
    format!("genom::event {}({})", codel.name, list.join(", "))
}
