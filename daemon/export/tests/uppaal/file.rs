//! Reads a file: its templates become processes.

use std::collections::HashMap;

use roxmltree::{Document, Node, ParsingOptions};

use super::code::{Expr, Kind, Type};
use super::express::Reader;
use super::memory::{Fixed, Values};
use super::names::{Name, Names};

/// A network of timed automata.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) fixed: Fixed,
    pub(crate) first: Values,
    pub(crate) processes: Vec<Process>,
    pub(crate) queries: Vec<Query>,
    names: Names,
}

#[derive(Debug)]
pub(crate) struct Process {
    pub(crate) init: usize,
    pub(crate) places: Vec<Place>,
    pub(crate) edges: Vec<Edge>,
}

#[derive(Debug)]
pub(crate) struct Place {
    pub(crate) committed: bool,
    pub(crate) urgent: bool,
    pub(crate) invariant: Option<Expr>,
}

#[derive(Debug)]
pub(crate) struct Edge {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Values that are selected, from one to another.
    pub(crate) selects: Vec<(i32, i32)>,
    pub(crate) guard: Option<Expr>,
    /// It sends to an urgent broadcast channel, of which there is no receiver.
    pub(crate) urgent: bool,
    pub(crate) assign: Vec<Expr>,
}

#[derive(Debug)]
pub(crate) struct Query {
    /// For all states; else for one at least.
    pub(crate) all: bool,
    pub(crate) holds: Expr,
    pub(crate) comment: String,
}

fn children<'d>(node: Node<'d, 'd>, name: &'static str) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

fn text_of<'d>(node: Node<'d, 'd>, name: &'static str) -> &'d str {
    children(node, name).next().and_then(|child| child.text()).unwrap_or_default()
}

/// A label of a location or an edge; all others are unknown.
fn label<'d>(node: Node<'d, 'd>, kind: &str) -> Option<&'d str> {
    let mut found = children(node, "label").filter(|label| label.attribute("kind") == Some(kind));
    found.next().and_then(|label| label.text())
}

fn known(node: Node<'_, '_>, names: &[&str]) {
    for child in node.children().filter(Node::is_element) {
        let name = child.attribute("kind").unwrap_or_else(|| child.tag_name().name());
        assert!(names.contains(&name), "<{name}> is not known here");
    }
}

impl Model {
    /// # Panics
    /// If the text is no model, or uses what is not known here.
    pub(crate) fn new(text: &str) -> Self {
        let options = ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = Document::parse_with_options(text, options).expect("XML");
        let root = document.root_element();
        known(root, &["declaration", "template", "system", "queries"]);
        let mut names = Names::default();
        names.open();
        Reader::new(text_of(root, "declaration"), &mut names).declarations();
        let templates: HashMap<&str, Node<'_, '_>> =
            children(root, "template").map(|one| (text_of(one, "name"), one)).collect();
        let processes = processes(text_of(root, "system"), &templates, &mut names);
        let asked = children(root, "queries").flat_map(|all| children(all, "query"));
        let queries = asked.map(|one| query(one, &mut names)).collect();
        let mut numbers: Vec<i32> =
            names.fixed.ranges.iter().map(|(least, most)| 0.clamp(*least, *most)).collect();
        names.first.iter().for_each(|(at, value)| numbers[*at] = *value);
        let first = Values { numbers, clocks: vec![0; names.clocks.len()] };
        Self { fixed: names.fixed.clone(), first, processes, queries, names }
    }

    /// An expression about its variables.
    pub(crate) fn expression(&mut self, text: &str) -> Expr {
        Reader::new(text, &mut self.names).pure(Kind::Int)
    }

    /// The clocks, by name and index.
    pub(crate) fn clocks(&self) -> &[(String, usize)] {
        &self.names.clocks
    }
}

/// `NAME = TEMPLATE(NUMBERS);` for each, then `system NAMES;`, where a template without parameters may
/// stand for itself.
fn processes(
    text: &str,
    templates: &HashMap<&str, Node<'_, '_>>,
    names: &mut Names,
) -> Vec<Process> {
    let mut made: HashMap<String, (String, Vec<i32>)> = HashMap::new();
    let mut reader = Reader::new(text, names);
    while !reader.takes("system") {
        let name = reader.name();
        reader.expect("=");
        let template = reader.name();
        reader.expect("(");
        let mut given = vec![reader.constant()];
        while reader.takes(",") {
            given.push(reader.constant());
        }
        reader.expect(")");
        reader.expect(";");
        let known = reader.names.find(&name).is_some() || templates.contains_key(name.as_str());
        assert!(!known && made.insert(name.clone(), (template, given)).is_none(), "{name}: twice");
    }
    let mut system = vec![reader.name()];
    while reader.takes(",") {
        system.push(reader.name());
    }
    reader.expect(";");
    reader.end();
    let mut all = Vec::new();
    for name in system {
        let (template, given) = made.remove(&name).unwrap_or_else(|| (name, Vec::new()));
        all.push(process(templates[template.as_str()], &given, names));
    }
    assert!(made.is_empty(), "no part of the system: {made:?}");
    all
}

fn process(template: Node<'_, '_>, given: &[i32], names: &mut Names) -> Process {
    known(template, &["name", "parameter", "location", "init", "transition"]);
    names.open();
    let mut reader = Reader::new(text_of(template, "parameter"), names);
    for (at, value) in given.iter().enumerate() {
        if at > 0 {
            reader.expect(",");
        }
        reader.expect("const");
        let Type::Int(least, most) = reader.type_() else { panic!("a parameter is no number") };
        assert!((least..=most).contains(value), "{value} is given");
        let name = reader.name();
        reader.names.add(&name, Name::Number(*value));
    }
    reader.end();
    let ids: Vec<&str> =
        children(template, "location").filter_map(|one| one.attribute("id")).collect();
    let at = |node: Node<'_, '_>| {
        let wanted = node.attribute("ref").expect("a location");
        ids.iter().position(|id| *id == wanted).expect("a location of the template")
    };
    let places = children(template, "location").map(|one| {
        known(one, &["name", "invariant", "urgent", "committed"]);
        Place {
            committed: children(one, "committed").next().is_some(),
            urgent: children(one, "urgent").next().is_some(),
            invariant: label(one, "invariant").map(|text| whole(text, Kind::Invariant, names)),
        }
    });
    let places = places.collect();
    let one = |name: &'static str, of| children(of, name).next().expect("one of each");
    let edges = children(template, "transition").map(|edge| Edge {
        from: at(one("source", edge)),
        to: at(one("target", edge)),
        ..labels(edge, names)
    });
    let process = Process { edges: edges.collect(), places, init: at(one("init", template)) };
    names.close();
    process
}

fn whole(text: &str, most: Kind, names: &mut Names) -> Expr {
    let mut reader = Reader::new(text, names);
    let expr = reader.pure(most);
    reader.end();
    expr
}

fn labels(edge: Node<'_, '_>, names: &mut Names) -> Edge {
    known(edge, &["source", "target", "select", "guard", "synchronisation", "assignment"]);
    names.open();
    let mut selects = Vec::new();
    if let Some(text) = label(edge, "select") {
        (names.frame, names.in_function) = (0, true);
        let mut reader = Reader::new(text, names);
        loop {
            let name = reader.name();
            reader.expect(":");
            let of = reader.type_();
            let Type::Int(least, most) = of else { panic!("{name} is {of:?}") };
            selects.push((least, most));
            reader.names.variable(&name, &of);
            if !reader.takes(",") {
                break;
            }
        }
        reader.end();
        names.in_function = false;
    }
    let urgent = label(edge, "synchronisation").is_some_and(|text| {
        let channel = text.strip_suffix('!').expect("nobody receives");
        assert!(matches!(names.find(channel), Some(Name::Channel)), "{channel}");
        true
    });
    // No clock may be where time must not pass.
    let most = if urgent { Kind::Int } else { Kind::Guard };
    let guard = label(edge, "guard").map(|text| whole(text, most, names));
    let mut assign = Vec::new();
    if let Some(text) = label(edge, "assignment") {
        let mut reader = Reader::new(text, names);
        assign.push(reader.effect());
        while reader.takes(",") {
            assign.push(reader.effect());
        }
        reader.end();
    }
    names.close();
    Edge { from: 0, to: 0, selects, guard, urgent, assign }
}

fn query(of: Node<'_, '_>, names: &mut Names) -> Query {
    let formula = text_of(of, "formula");
    let (all, rest) = match formula.strip_prefix("A[]") {
        Some(rest) => (true, rest),
        None => (false, formula.strip_prefix("E<>").expect("a query")),
    };
    // `not` is a word for `!` there.
    let not = rest.trim_start().strip_prefix("not ");
    let holds = whole(not.unwrap_or(rest), Kind::Constraint, names);
    let holds = if not.is_some() { Expr::Not(Box::new(holds)) } else { holds };
    Query { all, holds, comment: text_of(of, "comment").to_owned() }
}
