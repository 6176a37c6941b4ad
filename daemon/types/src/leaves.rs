//! The numbers within values of a type: what a plot can show.

use crate::data_type::DataType;
use crate::graph::{Graph, Ix, Scalar, Shape};
use crate::memory::View;
use crate::record::Record;

/// Elements of an array or a sequence that [`Leaf::first`] looks at.
const ELEMENTS: usize = 16;
/// How deep it looks: types may be nested without end through sequences.
const DEEPEST: usize = 8;
/// Name of a value that is a number itself.
const WHOLE: &str = "value";

/// A number within the values of a type, by its place: `pose.position.x`, `ranges[17]`, or `value`
/// for a value that is a number itself.
///
/// ```
/// use std::sync::Arc;
/// use genom_types::{DataType, Kind, Leaf, Record, TypeTable};
///
/// let mut table = TypeTable::default();
/// let element = table.add(Kind::Double);
/// let id = table.add(Kind::Array { element, length: 3 });
/// let ty = DataType::new(&Arc::new(table), id)?;
/// let leaf = Leaf::new(&ty, "[2]")?;
/// let mut value = Record::new(&ty);
/// value.merge_json(&serde_json::json!([0.5, 1.5, 2.5]))?;
/// assert_eq!(leaf.read(&value), Some(2.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Leaf {
    root: DataType,
    name: String,
    steps: Vec<Step>,
}

/// A step from a value to one inside it. Optionals take none.
#[derive(Clone, Copy, Debug)]
enum Step {
    Member(usize),
    Element(usize),
}

/// Why there is no such number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LeafError {
    /// The text is no path.
    #[error("`{0}` is no path to a number: write `member.array[3]`")]
    Form(String),
    /// A member is missing.
    #[error("{ty} has no member `{member}`")]
    Member {
        /// Spelling of the type.
        ty: String,
        /// What was asked for.
        member: String,
    },
    /// An element is missing.
    #[error("{ty} has no element [{index}]")]
    Element {
        /// Spelling of the type.
        ty: String,
        /// What was asked for.
        index: usize,
    },
    /// What is there is no number.
    #[error("`{path}` is {ty}, which is no number")]
    NoNumber {
        /// Where it leads.
        path: String,
        /// Spelling of the type there.
        ty: String,
    },
}

impl Leaf {
    /// The number at a place within values of this type.
    ///
    /// # Errors
    /// The path leads nowhere, or to something else.
    pub fn new(ty: &DataType, path: &str) -> Result<Self, LeafError> {
        let graph = ty.graph();
        let (mut here, mut steps) = (inner(graph, ty.ix()), Vec::new());
        for part in parts(if path == WHOLE && is_number(graph, here) { "" } else { path })? {
            let node = graph.node(here);
            let name = || node.name.clone();
            let (step, to) = match (&node.shape, part) {
                (
                    Shape::Struct { members } | Shape::Union { members, .. },
                    Part::Member(wanted),
                ) => {
                    let at = members.iter().position(|part| part.name == wanted);
                    let Some(at) = at else {
                        return Err(LeafError::Member { ty: name(), member: wanted.to_owned() });
                    };
                    (Step::Member(at), members[at].ix)
                }
                (_, Part::Member(wanted)) => {
                    return Err(LeafError::Member { ty: name(), member: wanted.to_owned() });
                }
                (&Shape::Array { element, length }, Part::Element(index)) if index < length => {
                    (Step::Element(index), element)
                }
                (&Shape::Sequence { element, bound }, Part::Element(index))
                    if bound.is_none_or(|bound| index < bound) =>
                {
                    (Step::Element(index), element)
                }
                (_, Part::Element(index)) => {
                    return Err(LeafError::Element { ty: name(), index });
                }
            };
            steps.push(step);
            here = inner(graph, to);
        }
        if !is_number(graph, here) {
            let ty = graph.node(here).name.clone();
            return Err(LeafError::NoNumber { path: path.to_owned(), ty });
        }
        Ok(Self { root: ty.clone(), name: path.to_owned(), steps })
    }

    /// The first numbers within values of this type, in order of declaration, at most this many.
    #[must_use]
    pub fn first(ty: &DataType, most: usize) -> Vec<Self> {
        let mut search = Search { root: ty, most, found: Vec::new(), steps: Vec::new() };
        search.look(ty.ix(), "");
        search.found
    }

    /// Its path.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number in this value: an integer, a float, 0 or 1 for a boolean, the rank of an
    /// enumerator. `None` if it is not there now, as beyond the end of a sequence, or if the value
    /// is of another type.
    #[must_use]
    pub fn read(&self, value: &Record) -> Option<f64> {
        if !value.ty().same_as(&self.root) {
            return None;
        }
        let mut view = present(value.view())?;
        for step in &self.steps {
            let to = match *step {
                Step::Member(index) => view.member(index),
                Step::Element(index) => view.element(index),
            };
            view = present(to?)?;
        }
        number(view)
    }
}

struct Search<'a> {
    root: &'a DataType,
    most: usize,
    found: Vec<Leaf>,
    steps: Vec<Step>,
}

impl Search<'_> {
    fn look(&mut self, ix: Ix, name: &str) {
        if self.found.len() >= self.most || self.steps.len() > DEEPEST {
            return;
        }
        let graph = self.root.graph();
        let ix = inner(graph, ix);
        match &graph.node(ix).shape {
            Shape::Struct { members } | Shape::Union { members, .. } => {
                for (at, part) in members.iter().enumerate() {
                    let dot = if name.is_empty() { "" } else { "." };
                    self.enter(Step::Member(at), part.ix, &format!("{name}{dot}{}", part.name));
                }
            }
            Shape::Array { element, length } => self.elements(*element, *length, name),
            Shape::Sequence { element, bound } => {
                self.elements(*element, bound.unwrap_or(usize::MAX), name);
            }
            _ if is_number(graph, ix) => {
                let name = if name.is_empty() { WHOLE } else { name }.to_owned();
                let (root, steps) = (self.root.clone(), self.steps.clone());
                self.found.push(Leaf { root, name, steps });
            }
            _ => {}
        }
    }

    fn elements(&mut self, element: Ix, length: usize, name: &str) {
        for index in 0..length.min(ELEMENTS) {
            self.enter(Step::Element(index), element, &format!("{name}[{index}]"));
        }
    }

    fn enter(&mut self, step: Step, to: Ix, name: &str) {
        self.steps.push(step);
        self.look(to, name);
        self.steps.pop();
    }
}

/// A part of a path.
#[derive(Debug, PartialEq)]
enum Part<'a> {
    Member(&'a str),
    Element(usize),
}

fn parts(path: &str) -> Result<Vec<Part<'_>>, LeafError> {
    let wrong = || LeafError::Form(path.to_owned());
    let (mut rest, mut found) = (path, Vec::new());
    while !rest.is_empty() {
        if let Some(inside) = rest.strip_prefix('[') {
            let (index, after) = inside.split_once(']').ok_or_else(wrong)?;
            found.push(Part::Element(index.parse().map_err(|_| wrong())?));
            rest = after;
            continue;
        }
        rest = match rest.strip_prefix('.') {
            Some(after) if !found.is_empty() => after,
            None if found.is_empty() => rest,
            _ => return Err(wrong()),
        };
        let end = rest.find(['.', '[']).unwrap_or(rest.len());
        if end == 0 {
            return Err(wrong());
        }
        found.push(Part::Member(&rest[..end]));
        rest = &rest[end..];
    }
    Ok(found)
}

/// The type, or what an optional is of.
fn inner(graph: &Graph, mut ix: Ix) -> Ix {
    while let Shape::Optional { element } = graph.node(ix).shape {
        ix = element;
    }
    ix
}

fn is_number(graph: &Graph, ix: Ix) -> bool {
    match graph.node(ix).shape {
        Shape::Scalar(scalar) => scalar != Scalar::Char,
        Shape::Enum { .. } => true,
        _ => false,
    }
}

/// The value, or what is in an optional.
fn present(mut view: View<'_>) -> Option<View<'_>> {
    while let Shape::Optional { .. } = view.node().shape {
        view = view.value()?;
    }
    Some(view)
}

fn number(view: View<'_>) -> Option<f64> {
    match view.node().shape {
        Shape::Scalar(Scalar::Float | Scalar::Double) => Some(view.real()),
        #[allow(clippy::cast_precision_loss, reason = "for a plot")]
        Shape::Scalar(_) | Shape::Enum { .. } => Some(view.integer() as f64),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use serde_json::json;

    use super::*;
    use crate::kind::{Kind, Member, ScopedName};
    use crate::table::TypeTable;

    /// `struct all { double a[2]; boolean on; string s; sequence<point> points; optional<long> l; }`
    fn all() -> DataType {
        let mut table = TypeTable::default();
        let double = table.add(Kind::Double);
        let array = table.add(Kind::Array { element: double, length: 2 });
        let on = table.add(Kind::Boolean);
        let text = table.add(Kind::String { bound: None });
        let point = table.add(Kind::Struct {
            name: ScopedName::new(["point"]),
            members: vec![Member { name: "x".into(), ty: double }],
        });
        let points = table.add(Kind::Sequence { element: point, bound: None });
        let long = table.add(Kind::Long);
        let maybe = table.add(Kind::Optional { element: long });
        let members = [("a", array), ("on", on), ("s", text), ("points", points), ("l", maybe)];
        let members = members.map(|(name, ty)| Member { name: name.into(), ty }).into();
        let id = table.add(Kind::Struct { name: ScopedName::new(["all"]), members });
        DataType::new(&Arc::new(table), id).unwrap()
    }

    #[test]
    fn numbers_are_found_by_their_place_and_read_while_they_are_there() {
        let ty = all();
        let mut value = Record::new(&ty);
        let json = json!({"a": [1.5, -2], "on": true, "points": [{"x": 7}], "l": 40});
        value.merge_json(&json).unwrap();
        let read = |path: &str| Leaf::new(&ty, path).unwrap().read(&value);
        assert_eq!(
            (read("a[1]"), read("on"), read("points[0].x")),
            (Some(-2.0), Some(1.0), Some(7.0))
        );
        assert_eq!((read("l"), read("points[1].x")), (Some(40.0), None));
        value.merge_json(&json!({"l": null})).unwrap();
        assert_eq!(Leaf::new(&ty, "l").unwrap().read(&value), None);
        for wrong in [
            "",
            "b",
            "a",
            "s",
            "a[2]",
            "a.x",
            "points[0]",
            "a[",
            "a[x]",
            ".a",
            "a..b",
            "a[1]b",
            "value",
        ] {
            assert!(Leaf::new(&ty, wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_first_numbers_are_those_of_the_declaration() {
        let names = |most| {
            let all = Leaf::first(&all(), most);
            all.iter().map(|leaf| leaf.name().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(names(4), ["a[0]", "a[1]", "on", "points[0].x"]);
        let many = names(64);
        assert_eq!((many.len(), many.last().unwrap().as_str()), (2 + 1 + ELEMENTS + 1, "l"));
        let mut table = TypeTable::default();
        let id = table.add(Kind::Long);
        let number = DataType::new(&Arc::new(table), id).unwrap();
        let leaves = Leaf::first(&number, 3);
        assert_eq!(leaves.iter().map(Leaf::name).collect::<Vec<_>>(), [WHOLE]);
        assert!(Leaf::new(&number, WHOLE).is_ok());
    }
}
