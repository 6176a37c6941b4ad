//! Memory layout of IDL types in C++ (genom3.md 6), with the corresponding layout in C.

use std::collections::HashMap;
use std::sync::Arc;

use genom_types::{DataType, Kind, TypeId};

use super::error::CxxTypeError;
use super::facts;

/// A type and all types inside it, in both layouts. Cloning costs one reference count.
#[derive(Clone, Debug)]
pub(crate) struct CxxType {
    pub(super) graph: Arc<Graph>,
    pub(super) node: usize,
}

/// Nodes refer to each other by index.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
}

/// One type.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) c: DataType,
    pub(super) size: usize,
    pub(super) align: usize,
    /// The layout is that of C, and values own no memory.
    pub(super) same: bool,
    pub(super) shape: Shape,
}

/// The structure of a type.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// The layout of C.
    Plain,
    /// `std::string`.
    String,
    /// `std::vector<bool>`.
    Flags,
    /// `std::vector<T>`.
    Vector { element: usize },
    /// `genom::bounded_sequence<T, bound>`: all elements are constructed; the number of valid ones
    /// is at offset `length_at`.
    Bounded { element: usize, bound: usize, length_at: usize },
    /// `T[length]`.
    Array { element: usize, length: usize },
    /// `genom::optional<T>`: the value is constructed also while absent.
    Optional { element: usize, at: usize, c_at: usize },
    /// A struct, or the detail of an exception.
    Struct { parts: Vec<Part> },
}

/// A member.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) node: usize,
    pub(super) at: usize,
    pub(super) c_at: usize,
}

impl CxxType {
    /// Lays out the C++ equivalent of a type.
    ///
    /// # Errors
    /// C++ has no equivalent.
    pub(crate) fn new(c: &DataType) -> Result<Self, CxxTypeError> {
        let (string, flags) = facts::sizes().ok_or(CxxTypeError::OtherLibrary)?;
        let mut builder = Builder { graph: Graph::default(), known: HashMap::new(), string, flags };
        let node = builder.add(c)?;
        Ok(Self { graph: Arc::new(builder.graph), node })
    }

    pub(super) fn at(&self, node: usize) -> Self {
        Self { graph: Arc::clone(&self.graph), node }
    }

    pub(super) fn node(&self) -> &Node {
        &self.graph.nodes[self.node]
    }

    /// The type in C layout.
    pub(crate) fn c(&self) -> &DataType {
        &self.node().c
    }

    /// Size in bytes, as C++'s `sizeof`.
    pub(crate) fn size(&self) -> usize {
        self.node().size
    }

    /// Offset in bytes of a member of a struct, of the value of an optional (`rank` 0), or of the
    /// length of a bounded sequence (`rank` 1).
    pub(crate) fn offset(&self, rank: usize) -> usize {
        match &self.node().shape {
            Shape::Struct { parts } => parts.get(rank).map_or(0, |part| part.at),
            Shape::Optional { at, .. } => *at,
            Shape::Bounded { length_at, .. } => *length_at,
            _ => match self.c().kind() {
                Kind::Optional { .. } => self.c().layout().offsets.first().copied().unwrap_or(0),
                _ => self.c().member_offset(rank).unwrap_or(0),
            },
        }
    }

    /// Whether the layout is that of C, and values own no memory.
    pub(crate) fn is_plain(&self) -> bool {
        self.node().same
    }
}

struct Builder {
    graph: Graph,
    known: HashMap<TypeId, usize>,
    string: usize,
    flags: usize,
}

impl Builder {
    fn push(&mut self, c: &DataType, size: usize, align: usize, shape: Shape) -> usize {
        let same = matches!(shape, Shape::Plain);
        self.graph.nodes.push(Node { c: c.clone(), size, align, same, shape });
        self.graph.nodes.len() - 1
    }

    fn plain(&mut self, c: &DataType) -> usize {
        self.push(c, c.size(), c.align(), Shape::Plain)
    }

    /// Adds a node for a type that contains `inside`; it has the layout of C if all of these have.
    fn over(&mut self, c: &DataType, inside: &[usize], built: (usize, usize, Shape)) -> usize {
        if inside.iter().all(|node| self.graph.nodes[*node].same) {
            return self.plain(c);
        }
        self.push(c, built.0, built.1, built.2)
    }

    fn add(&mut self, c: &DataType) -> Result<usize, CxxTypeError> {
        if let Some(node) = self.known.get(&c.id()) {
            return Ok(*node);
        }
        let node = match c.kind() {
            Kind::String { bound: None } => self.push(c, self.string, 8, Shape::String),
            Kind::Sequence { element, bound: None }
                if *c.table().resolved(*element) == Kind::Boolean =>
            {
                self.push(c, self.flags, 8, Shape::Flags)
            }
            Kind::Sequence { bound: None, .. } => {
                // Added before its element: a struct may contain sequences of itself.
                let node = self.push(c, 24, 8, Shape::Vector { element: 0 });
                self.known.insert(c.id(), node);
                let element = self.element(c)?;
                self.graph.nodes[node].shape = Shape::Vector { element };
                node
            }
            Kind::Sequence { bound: Some(bound), .. } => {
                let bound = *bound as usize;
                let element = self.element(c)?;
                let inside = &self.graph.nodes[element];
                let length_at = (inside.size * bound).next_multiple_of(8);
                let shape = Shape::Bounded { element, bound, length_at };
                self.push(c, length_at + 8, inside.align.max(8), shape)
            }
            Kind::Array { length, .. } => {
                let length = *length as usize;
                let element = self.add(&inner(c)?)?;
                let inside = &self.graph.nodes[element];
                let (size, align) = (inside.size * length, inside.align);
                self.over(c, &[element], (size, align, Shape::Array { element, length }))
            }
            Kind::Optional { .. } => {
                let element = self.add(&inner(c)?)?;
                let inside = &self.graph.nodes[element];
                let (at, align) = (inside.align.max(1), inside.align.max(1));
                let size = (at + inside.size).next_multiple_of(align);
                let c_at = c.layout().offsets.first().copied().unwrap_or_default();
                self.over(c, &[element], (size, align, Shape::Optional { element, at, c_at }))
            }
            Kind::Struct { .. } | Kind::Exception { .. } => self.structure(c)?,
            Kind::Union { .. } => self.union(c)?,
            Kind::Any | Kind::Forward { .. } => {
                return Err(CxxTypeError::None { ty: c.name().to_owned() });
            }
            _ => self.plain(c),
        };
        self.known.insert(c.id(), node);
        Ok(node)
    }

    fn structure(&mut self, c: &DataType) -> Result<usize, CxxTypeError> {
        let (mut parts, mut end, mut align) = (Vec::new(), 0_usize, 1);
        for rank in 0..c.member_count() {
            let (Some(member), Some(c_at)) = (c.member(rank), c.member_offset(rank)) else {
                continue;
            };
            let node = self.add(&member)?;
            let inside = &self.graph.nodes[node];
            let at = end.next_multiple_of(inside.align);
            end = at + inside.size;
            align = align.max(inside.align);
            parts.push(Part { node, at, c_at });
        }
        let inside: Vec<usize> = parts.iter().map(|part| part.node).collect();
        let shape = Shape::Struct { parts };
        Ok(self.over(c, &inside, (end.next_multiple_of(align), align, shape)))
    }

    /// genom3.md 6: members of a union have no constructors, so it has the layout of C.
    fn union(&mut self, c: &DataType) -> Result<usize, CxxTypeError> {
        for rank in 0..c.member_count() {
            let Some(member) = c.member(rank) else { continue };
            let node = self.add(&member)?;
            if !self.graph.nodes[node].same {
                return Err(CxxTypeError::UnionMember {
                    member: c.member_name(rank).unwrap_or_default().to_owned(),
                    ty: member.name().to_owned(),
                    union: c.name().to_owned(),
                });
            }
        }
        Ok(self.plain(c))
    }

    /// The element of a sequence: C++ has no vectors of arrays.
    fn element(&mut self, c: &DataType) -> Result<usize, CxxTypeError> {
        let element = inner(c)?;
        if let Kind::Array { .. } | Kind::String { bound: Some(_) } = element.kind() {
            return Err(CxxTypeError::ArrayElement {
                ty: c.name().to_owned(),
                element: element.name().to_owned(),
            });
        }
        self.add(&element)
    }
}

fn inner(c: &DataType) -> Result<DataType, CxxTypeError> {
    c.element().ok_or_else(|| CxxTypeError::NoElement { ty: c.name().to_owned() })
}
