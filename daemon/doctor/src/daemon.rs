//! Findings about a daemon: its middlewares, cells, components, and their connections.

use std::collections::BTreeMap;
use std::path::Path;

use genom_protocol::{
    Cell, CellState, Components, Diagnosis, Finding, Middleware, Refused, Remedy, Statistics,
    Trouble, advice, routes,
};

use crate::codels;
use crate::machine::Machine;
use crate::memory::{self, PREFIXES};
use crate::ros;

/// What the control plane of a daemon answered.
#[derive(Debug)]
pub struct Seen {
    /// Its middlewares.
    pub middlewares: Vec<Middleware>,
    /// Its cells and gateways.
    pub cells: Vec<Cell>,
    /// Its components.
    pub components: Components,
    /// Statistics of components, by name.
    pub statistics: BTreeMap<String, Statistics>,
    /// Why no data flows through ports, by component.
    pub ports: BTreeMap<String, Vec<Finding>>,
    /// Ports that were not asked about, since that took too long.
    pub unasked: usize,
}

/// What is wrong. Looks at the shared memory of the daemon, which is on this machine.
#[must_use]
pub fn of_daemon(seen: &Seen) -> Vec<Diagnosis> {
    let Seen { middlewares, cells, components, statistics, ports, unasked } = seen;
    let versions: Vec<_> = middlewares.iter().map(|one| one.version.as_str()).collect();
    let mut found = vec![Diagnosis::ok("middlewares", versions.join("; "))];
    found.extend(middlewares.iter().flat_map(refused));
    found.extend(middlewares.iter().flat_map(trouble));
    found.extend(shared_memory(middlewares));
    if let Some(ros2) = middlewares.iter().find(|one| one.name == "ros2") {
        found.extend(ros::nodes(&Machine::at(Path::new("/")), &ros2.meet).into_iter().flatten());
    }
    found.extend(cells.iter().filter_map(cell));
    found.extend(components.left_behind.iter().map(codels::left));
    for component in &components.components {
        let name = &component.name;
        found.extend(codels::of_component(component));
        let unmet = ports.get(name).into_iter().flatten().filter(|one| one.unmet);
        found.extend(unmet.map(|one| Diagnosis {
            remedies: one.remedies.clone(),
            ..Diagnosis::problem("ports", one.what.as_str(), one.fix.as_str())
        }));
        let tasks = statistics.get(name).into_iter().flat_map(|all| &all.tasks);
        for task in tasks.filter(|task| task.overruns > 0) {
            let what = format!("task {} of {name} missed {} ticks", task.name, task.overruns);
            found.push(Diagnosis::note("tasks", what, advice::overruns(name)));
        }
    }
    if *unasked > 0 {
        let what = format!("{unasked} ports were not examined: that took too long");
        found.push(Diagnosis::note("ports", what, "`genomctl why COMPONENT/PORT` examines one"));
    }
    found
}

/// Harmful messages of peers that a middleware dropped.
fn refused(middleware: &Middleware) -> impl Iterator<Item = Diagnosis> {
    let name = &middleware.name;
    middleware.refused.iter().map(move |Refused { why, count, peer }| {
        let peer = peer.map_or_else(String::new, |peer| format!(", the last one from {peer}"));
        let what = format!("{name} refused {count} messages: {why}{peer}");
        let fix = format!("see who sends that; {} tells of limits", about(name));
        Diagnosis::note("refused", what, fix)
    })
}

/// What tells of the keys of a middleware in configurations.
fn about(name: &str) -> String {
    match name {
        "ros2" | "shm" | "yarp" | "zenoh" => format!("configs/{name}.toml"),
        _ => "the documentation of its library".to_owned(),
    }
}

/// What keeps a middleware from others, or why it is not open.
fn trouble(middleware: &Middleware) -> Vec<Diagnosis> {
    let name = &middleware.name;
    let closed = middleware.closed.iter().map(|why| {
        let fix = format!("correct [backends.{name}]; {} tells of its keys", about(name));
        Diagnosis::problem(name, format!("it was needed and could not be opened: {why}"), fix)
    });
    let told =
        |Trouble { what, fix }: &Trouble| Diagnosis::problem(name, what.as_str(), fix.as_str());
    closed.chain(middleware.trouble.iter().map(told)).collect()
}

/// Stale and damaged segments in the shared memory that this daemon uses.
fn shared_memory(known: &[Middleware]) -> Vec<Diagnosis> {
    let Some(shm) = known.iter().find(|one| one.name == "shm") else { return Vec::new() };
    let (Some(root), Some(prefix)) = (shm.meet.get("root"), shm.meet.get("prefix")) else {
        return Vec::new();
    };
    if PREFIXES.iter().any(|known| prefix.starts_with(known)) {
        // Inspected with the machine.
        return Vec::new();
    }
    let machine = Machine::at(Path::new("/"));
    vec![memory::nodes(&machine, std::slice::from_ref(root)), memory::segments(&machine, &[prefix])]
}

/// A cell that does not run, although nobody asked it to end.
fn cell(cell: &Cell) -> Option<Diagnosis> {
    const ABOUT: &str = "cells";
    let Cell { name, last_end, starts, components, .. } = cell;
    let end = last_end.as_ref().map_or_else(String::new, |end| format!(": {end}"));
    let with = match components.as_slice() {
        [] => String::new(),
        all => format!(", with {}", all.join(", ")),
    };
    let restart = || Remedy::new(format!("Start cell {name} again"), &routes::restart_cell(name));
    match cell.state {
        CellState::Failed => {
            let what = format!("cell {name} is down{with}{end}, after {starts} starts");
            let fix = format!(
                "`genomctl crashes` tells why; `genomctl cells --restart {name}` starts it again"
            );
            Some(Diagnosis::problem(ABOUT, what, fix).or(restart()))
        }
        CellState::Waiting => {
            let what = format!("cell {name} waits to be started again{with}{end}");
            let fix = format!("`genomctl cells --restart {name}` starts it now");
            Some(Diagnosis::note(ABOUT, what, fix).or(restart()))
        }
        CellState::Starting | CellState::Running | CellState::Stopping => None,
    }
}

#[cfg(test)]
mod tests {
    use genom_protocol::{Right, Severity};
    use serde_json::json;

    use super::*;

    fn seen(cells: serde_json::Value) -> Seen {
        Seen {
            middlewares: Vec::new(),
            cells: serde_json::from_value(cells).unwrap(),
            components: serde_json::from_value(json!({"components": []})).unwrap(),
            statistics: BTreeMap::new(),
            ports: BTreeMap::new(),
            unasked: 0,
        }
    }

    #[test]
    fn what_is_told_to_read_of_a_middleware_is_there() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
        for name in ["ros2", "shm", "yarp", "zenoh"] {
            let file = about(name);
            assert!(std::fs::exists(format!("{root}{file}")).unwrap(), "{file}");
        }
        assert_eq!(about("mine"), "the documentation of its library");
    }

    #[test]
    fn a_cell_that_is_down_is_a_problem_that_a_request_mends() {
        let cell = |state: &str| {
            json!({"name": "arm", "state": state, "components": ["demo"], "starts": 3,
                   "last_end": "signal 11 (SIGSEGV)", "socket": "/x"})
        };
        let found = of_daemon(&seen(json!([cell("failed"), cell("running")])));
        let [middlewares, failed] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(middlewares.level, Severity::Ok);
        assert_eq!(failed.what, "cell arm is down, with demo: signal 11 (SIGSEGV), after 3 starts");
        let remedy = &failed.remedies[0];
        assert_eq!((remedy.method.as_str(), remedy.right), ("POST", Right::Admin));
        assert_eq!(remedy.path, "/cells/arm/restart");
    }

    #[test]
    fn ports_that_were_not_asked_about_are_told() {
        let found = of_daemon(&Seen { unasked: 7, ..seen(json!([])) });
        assert!(found.iter().any(|one| one.what.starts_with("7 ports")), "{found:?}");
    }
}
