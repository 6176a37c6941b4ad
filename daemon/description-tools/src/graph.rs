//! Diagrams of a component: its parts, and the state machines of its tasks and activities.

use std::fmt::Write;

use genom_description::model::{
    Codel, CodelIx, CodelKind, Component, PortDirection, Service, ServiceKind, Source, StateIx,
};

/// Languages that diagrams are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Graph {
    /// Graphviz.
    Dot,
    /// Mermaid, as drawn by forges and documentation tools.
    Mermaid,
}

/// The component and each of its state machines, in one diagram.
#[must_use]
pub fn graph(component: &Component, language: Graph) -> String {
    let picture = picture(component);
    match language {
        Graph::Dot => dot(component, &picture),
        Graph::Mermaid => mermaid(component, &picture),
    }
}

#[derive(Default)]
struct Picture {
    boxes: Vec<Node>,
    arrows: Vec<Arrow>,
    machines: Vec<Machine>,
}

/// A part of the component.
struct Node {
    id: String,
    label: String,
    shape: Shape,
}

#[derive(Clone, Copy)]
enum Shape {
    Port,
    Task,
    Service,
}

struct Arrow {
    from: String,
    to: String,
    label: String,
    /// For a pause, and for relations other than data flow.
    dashed: bool,
}

/// A state machine.
struct Machine {
    id: String,
    title: String,
    states: Vec<(String, String)>,
    arrows: Vec<Arrow>,
}

fn picture(component: &Component) -> Picture {
    let mut picture = Picture::default();
    for port in &component.ports {
        let set = if port.multiple { "multiple " } else { "" };
        let way = if port.direction == PortDirection::In { "in" } else { "out" };
        let label = format!("{set}{way} {}", port.name);
        picture.boxes.push(Node { id: format!("port_{}", port.name), label, shape: Shape::Port });
    }
    for (ix, task) in component.tasks.pairs() {
        let id = format!("task_{}", task.name);
        let pace =
            task.period.map_or_else(|| "aperiodic".to_owned(), |period| format!("{period:?}"));
        let label = format!("task {} ({pace})", task.name);
        picture.boxes.push(Node { id: id.clone(), label, shape: Shape::Task });
        if !task.codels.is_empty() {
            let title = format!("task {}", task.name);
            picture.machine(component, &id, title, &task.codels);
            picture.data(component, &id, &task.codels);
        }
        for service in component.services.iter().filter(|service| service.task == Some(ix)) {
            let arrow = Arrow {
                from: id.clone(),
                to: service_id(service),
                label: "runs".to_owned(),
                dashed: true,
            };
            picture.arrows.push(arrow);
        }
    }
    for service in component.services.iter().filter(|service| !service.standard) {
        let id = service_id(service);
        let kind = match service.kind {
            ServiceKind::Attribute => "attribute",
            ServiceKind::Function => "function",
            ServiceKind::Activity => "activity",
        };
        let label = format!("{kind} {}", service.name);
        picture.boxes.push(Node { id: id.clone(), label: label.clone(), shape: Shape::Service });
        if service.kind == ServiceKind::Activity {
            picture.machine(component, &id, label, &service.codels);
        }
        picture.data(component, &id, &service.codels);
        for other in service.interrupts.iter().filter_map(|rank| component.services.get(*rank)) {
            if !other.standard {
                let (from, to) = (id.clone(), service_id(other));
                let label = "interrupts".to_owned();
                picture.arrows.push(Arrow { from, to, label, dashed: true });
            }
        }
    }
    picture
}

fn service_id(service: &Service) -> String {
    format!("service_{}", service.name)
}

impl Picture {
    /// Adds arrows between a part and the ports that its codels use, at most one in each direction.
    fn data(&mut self, component: &Component, id: &str, codels: &[CodelIx]) {
        let mut seen = std::collections::BTreeSet::new();
        let codels = codels.iter().filter_map(|ix| component.codels.get(*ix));
        for parameter in codels.flat_map(|codel| &codel.parameters) {
            let Source::Port(rank) = parameter.source else { continue };
            let Some(port) = component.ports.get(rank) else { continue };
            if !seen.insert(rank) {
                continue;
            }
            let port_id = format!("port_{}", port.name);
            let (from, to) = match port.direction {
                PortDirection::In => (port_id, id.to_owned()),
                PortDirection::Out => (id.to_owned(), port_id),
            };
            self.arrows.push(Arrow { from, to, label: String::new(), dashed: false });
        }
    }

    fn machine(&mut self, component: &Component, id: &str, title: String, codels: &[CodelIx]) {
        let state = |ix: StateIx| component.states.get(ix).map_or("?", String::as_str);
        let node = |ix: StateIx| format!("{id}__{}", state(ix));
        let mut machine =
            Machine { id: id.to_owned(), title, states: Vec::new(), arrows: Vec::new() };
        let mut known = std::collections::BTreeSet::new();
        let codels: Vec<&Codel> =
            codels.iter().filter_map(|ix| component.codels.get(*ix)).collect();
        for codel in &codels {
            let CodelKind::Fsm { triggers, .. } = &codel.kind else { continue };
            for trigger in triggers {
                let wait = if codel.asynchronous { "async " } else { "" };
                let label = format!("{}\\n{wait}{}", state(*trigger), codel.name);
                if known.insert(*trigger) {
                    machine.states.push((node(*trigger), label));
                }
            }
        }
        for codel in &codels {
            let CodelKind::Fsm { triggers, yields } = &codel.kind else { continue };
            for to in yields {
                if known.insert(to.state) {
                    machine.states.push((node(to.state), state(to.state).to_owned()));
                }
                for from in triggers {
                    let label = if to.pause { "pause" } else { "" }.to_owned();
                    let (from, to_node) = (node(*from), node(to.state));
                    machine.arrows.push(Arrow { from, to: to_node, label, dashed: to.pause });
                }
            }
        }
        self.machines.push(machine);
    }
}

fn dot(component: &Component, picture: &Picture) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "digraph {:?} {{\n  rankdir=LR;\n  node [fontname=\"sans-serif\"];\n  edge [fontname=\"sans-serif\"];\n",
        component.name
    );
    let _ = writeln!(out, "  subgraph cluster_component {{\n    label={:?};", component.name);
    for node in &picture.boxes {
        let shape = match node.shape {
            Shape::Port => "cds",
            Shape::Task => "component",
            Shape::Service => "box",
        };
        let _ = writeln!(out, "    {} [shape={shape}, label={:?}];", node.id, node.label);
    }
    out.push_str("  }\n");
    for machine in &picture.machines {
        let _ =
            writeln!(out, "  subgraph cluster_{} {{\n    label={:?};", machine.id, machine.title);
        for (id, label) in &machine.states {
            let _ = writeln!(out, "    {id} [shape=ellipse, label=\"{label}\"];");
        }
        for arrow in &machine.arrows {
            dot_arrow(&mut out, arrow, "    ");
        }
        out.push_str("  }\n");
    }
    for arrow in &picture.arrows {
        dot_arrow(&mut out, arrow, "  ");
    }
    out.push_str("}\n");
    out
}

fn dot_arrow(out: &mut String, arrow: &Arrow, indent: &str) {
    let mut attributes = Vec::new();
    if !arrow.label.is_empty() {
        attributes.push(format!("label={:?}", arrow.label));
    }
    if arrow.dashed {
        attributes.push("style=dashed".to_owned());
    }
    let shown =
        if attributes.is_empty() { String::new() } else { format!(" [{}]", attributes.join(", ")) };
    let _ = writeln!(out, "{indent}{} -> {}{shown};", arrow.from, arrow.to);
}

fn mermaid(component: &Component, picture: &Picture) -> String {
    let mut out = String::from("flowchart LR\n");
    let _ = writeln!(out, "  subgraph component[\"{}\"]", component.name);
    for node in &picture.boxes {
        let (open, close) = match node.shape {
            Shape::Port => ("[/", "/]"),
            Shape::Task => ("[[", "]]"),
            Shape::Service => ("[", "]"),
        };
        let _ = writeln!(out, "    {}{open}\"{}\"{close}", node.id, node.label);
    }
    out.push_str("  end\n");
    for machine in &picture.machines {
        let _ = writeln!(out, "  subgraph machine_{}[\"{}\"]", machine.id, machine.title);
        for (id, label) in &machine.states {
            let _ = writeln!(out, "    {id}([\"{}\"])", label.replace("\\n", "<br>"));
        }
        for arrow in &machine.arrows {
            mermaid_arrow(&mut out, arrow, "    ");
        }
        out.push_str("  end\n");
    }
    for arrow in &picture.arrows {
        mermaid_arrow(&mut out, arrow, "  ");
    }
    out
}

fn mermaid_arrow(out: &mut String, arrow: &Arrow, indent: &str) {
    let line = if arrow.dashed { "-.->" } else { "-->" };
    let label = if arrow.label.is_empty() { String::new() } else { format!("|{}|", arrow.label) };
    let _ = writeln!(out, "{indent}{} {line}{label} {}", arrow.from, arrow.to);
}
