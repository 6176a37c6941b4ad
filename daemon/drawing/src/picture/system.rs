//! What is drawn: components with their ports, foreign peers, and what connects them.

use std::collections::BTreeMap;

use genom_protocol::{
    Component, Connection, ConnectionKind, Middlewares, Port, PortDirection, Stranger,
};

/// A running system.
#[derive(Clone, Debug, Default)]
pub struct System {
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<Edge>,
}

/// Where values come from that clients publish.
const PUBLISHED: &str = "published values";

/// A component, or a peer that is none of this daemon's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Node {
    pub(crate) name: String,
    /// What else is to be said: its state, if it does not simply run.
    pub(crate) note: Option<String>,
    /// The cell that runs it.
    pub(crate) cell: Option<String>,
    pub(crate) foreign: bool,
    /// What is on its sides: in ports and services; out ports and remotes.
    pub(crate) left: Vec<String>,
    pub(crate) right: Vec<String>,
}

/// A connection of ports, from the writer to the reader; or of a remote and a service, from the
/// caller to who serves it.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    /// Index of a node, and which of its right side.
    pub(crate) from: (usize, usize),
    /// Index of a node, and which of its left side.
    pub(crate) to: (usize, usize),
    pub(crate) backend: Option<String>,
    pub(crate) service: bool,
    /// Samples per second that the writer writes; for what is none of the daemon's, that the reader
    /// reads.
    pub(crate) rate: Option<f64>,
}

/// What the daemon says of itself.
#[derive(Debug)]
pub struct Told {
    /// Its components.
    pub components: Vec<Component>,
    /// Their ports.
    pub ports: Vec<Port>,
    /// Connections of ports, and of remotes with services.
    pub connections: Vec<Connection>,
    /// What is visible on middlewares, if it is known.
    pub middlewares: Option<Middlewares>,
}

impl System {
    /// What the daemon said, with the samples per second of ports, by their address.
    #[must_use]
    pub fn of(told: Told, rates: &BTreeMap<String, f64>) -> Self {
        let mut system = Self::default();
        for component in told.components {
            let runs = component.state == "running";
            system.nodes.push(Node {
                name: component.name,
                note: (!runs).then_some(component.state),
                cell: component.cell,
                ..Node::default()
            });
        }
        // In the order of descriptions, also those that are not connected.
        for port in told.ports {
            let Some((component, name)) = port.address.split_once('/') else { continue };
            match port.direction {
                PortDirection::In => _ = system.left(component, name),
                PortDirection::Out => _ = system.right(component, name),
            }
        }
        for one in told.connections {
            let (backend, out) = place(&one.outport);
            let (Some((reader, inport)), Some((writer, outport))) =
                (one.inport.split_once('/'), split(out))
            else {
                continue;
            };
            // An in port that reads its own address reads what clients publish there.
            let writer = if one.inport == out { PUBLISHED } else { writer };
            let service = one.kind == ConnectionKind::Service;
            let backend = one.backend.or(backend);
            let edge = match service {
                false => Edge {
                    from: system.right(writer, outport),
                    to: system.left(reader, inport),
                    rate: rates.get(out).or_else(|| rates.get(&one.inport)).copied(),
                    backend,
                    service,
                },
                true => Edge {
                    from: system.right(reader, inport),
                    to: system.left(writer, outport),
                    rate: None,
                    backend,
                    service,
                },
            };
            system.edges.push(edge);
        }
        for middleware in told.middlewares.into_iter().flat_map(|all| all.middlewares) {
            for stranger in middleware.strangers {
                let Stranger::Reader { address } = stranger else { continue };
                let Some((writer, outport)) = split(&address) else { continue };
                let reader = format!("a program on {}", middleware.name);
                let edge = Edge {
                    from: system.right(writer, outport),
                    to: system.left(&reader, outport),
                    backend: Some(middleware.name.clone()),
                    service: false,
                    rate: rates.get(&address).copied(),
                };
                system.edges.push(edge);
            }
        }
        system
    }

    /// The node of this name; a foreign one if there is none yet.
    fn node(&mut self, name: &str) -> usize {
        let found = self.nodes.iter().position(|node| node.name == name);
        found.unwrap_or_else(|| {
            self.nodes.push(Node { name: name.to_owned(), foreign: true, ..Node::default() });
            self.nodes.len() - 1
        })
    }

    fn left(&mut self, node: &str, name: &str) -> (usize, usize) {
        let node = self.node(node);
        (node, place_of(&mut self.nodes[node].left, name))
    }

    fn right(&mut self, node: &str, name: &str) -> (usize, usize) {
        let node = self.node(node);
        (node, place_of(&mut self.nodes[node].right, name))
    }

    /// The middlewares of connections, each once.
    pub(crate) fn backends(&self) -> Vec<&str> {
        let mut all: Vec<_> =
            self.edges.iter().filter_map(|edge| edge.backend.as_deref()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The cells, in order of their first component, each with its nodes; nodes of no cell and
    /// foreign ones have groups of their own.
    pub(crate) fn groups(&self) -> Vec<(Group<'_>, Vec<usize>)> {
        let mut groups: Vec<(Group<'_>, Vec<usize>)> = Vec::new();
        for (index, node) in self.nodes.iter().enumerate() {
            let of = match (&node.cell, node.foreign) {
                (_, true) => Group::Foreign,
                (Some(cell), _) => Group::Cell(cell),
                (None, _) => Group::Daemon,
            };
            match groups.iter_mut().find(|(group, _)| *group == of) {
                Some((_, nodes)) => nodes.push(index),
                None => groups.push((of, vec![index])),
            }
        }
        groups.sort_by_key(|(group, _)| *group == Group::Foreign);
        groups
    }
}

/// What nodes are drawn together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group<'a> {
    /// The daemon's own process.
    Daemon,
    Cell(&'a str),
    /// Peers that are none of the daemon's.
    Foreign,
}

impl Group<'_> {
    /// Its title, if it has a frame.
    pub(crate) fn title(self) -> Option<String> {
        match self {
            Self::Cell(cell) => Some(format!("cell {cell}")),
            Self::Daemon | Self::Foreign => None,
        }
    }
}

/// `200 Hz`, with as many digits as say something.
pub(crate) fn hertz(rate: f64) -> String {
    if rate < 9.95 { format!("{rate:.1} Hz") } else { format!("{rate:.0} Hz") }
}

/// A connection in words: which ports it connects, and how fast.
pub(crate) fn words(system: &System, edge: &Edge) -> String {
    let from = &system.nodes[edge.from.0].right[edge.from.1];
    let to = &system.nodes[edge.to.0].left[edge.to.1];
    let names = if from == to { from.clone() } else { format!("{from} → {to}") };
    edge.rate.map_or_else(|| names.clone(), |rate| format!("{names}, {}", hertz(rate)))
}

fn place_of(side: &mut Vec<String>, name: &str) -> usize {
    side.iter().position(|known| known == name).unwrap_or_else(|| {
        side.push(name.to_owned());
        side.len() - 1
    })
}

/// A middleware before the name, and the name.
fn place(address: &str) -> (Option<String>, &str) {
    match address.split_once(':') {
        Some((backend, name)) => (Some(backend.to_owned()), name),
        None => (None, address),
    }
}

/// The end and its port. An absolute name of a foreign middleware is both.
fn split(name: &str) -> Option<(&str, &str)> {
    if name.starts_with('/') {
        return Some((name, name.rsplit('/').next().unwrap_or(name)));
    }
    name.split_once('/')
}

#[cfg(test)]
pub(crate) mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// A system of two components and a foreign topic; one component is in a cell.
    pub(in crate::picture) fn example() -> System {
        let component = |name: &str, cell: Option<&str>, state: &str| {
            json!({
                "name": name, "component": name, "state": state, "backend": "shm",
                "library": "a.so", "activities": 0, "cell": cell,
            })
        };
        let port = |address: &str, direction: &str| {
            json!({
                "address": address, "name": "x", "direction": direction, "multiple": false,
                "type": "double", "backend": "shm",
            })
        };
        let connection = |kind: &str, inport: &str, outport: &str, backend: &str| json!({"kind": kind, "in": inport, "out": outport, "backend": backend});
        fn read<T: serde::de::DeserializeOwned>(all: Vec<Value>) -> Vec<T> {
            serde_json::from_value(Value::from(all)).unwrap()
        }
        let told = Told {
            components: read(vec![
                component("demo", None, "running"),
                component("arm", Some("right"), "down"),
            ]),
            ports: read(vec![
                port("demo/parameter", "in"),
                port("demo/position", "out"),
                port("arm/goal", "in"),
                port("arm/scan", "in"),
            ]),
            connections: read(vec![
                connection("port", "arm/goal", "demo/position", "shm"),
                connection("port", "arm/scan", "ros2:/front/scan", "ros2"),
                connection("service", "arm/move", "demo/goto", "shm"),
            ]),
            middlewares: None,
        };
        System::of(told, &BTreeMap::from([("demo/position".to_owned(), 200.0)]))
    }

    #[test]
    fn all_that_runs_is_there_with_what_connects_it() {
        let system = example();
        let names: Vec<_> =
            system.nodes.iter().map(|one| (one.name.as_str(), one.foreign)).collect();
        assert_eq!(names, [("demo", false), ("arm", false), ("/front/scan", true)]);
        assert_eq!(system.nodes[0].left, ["parameter", "goto"]);
        assert_eq!(system.nodes[1].right, ["move"]);
        assert_eq!(system.nodes[1].note.as_deref(), Some("down"));
        let told: Vec<_> = system.edges.iter().map(|edge| words(&system, edge)).collect();
        assert_eq!(told, ["position → goal, 200 Hz", "scan", "move → goto"]);
        assert_eq!(system.backends(), ["ros2", "shm"]);
        let groups: Vec<_> = system.groups().into_iter().map(|(group, _)| group).collect();
        assert_eq!(groups, [Group::Daemon, Group::Cell("right"), Group::Foreign]);
    }
}
