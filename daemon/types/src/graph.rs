//! A type and all types it is made of, laid out, as an array of nodes that refer to each other by
//! index.
//!
//! Built once per [`DataType`](crate::DataType); the table is not consulted afterwards.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use crate::cdr::step::CdrPlan;
pub(crate) use crate::ix::Ix;
use crate::kind::{Kind, Label, Member, ScopedName, TypeId};
use crate::layout::{Layout, LayoutError, MAX_NESTING, MAX_SIZE};
use crate::table::TypeTable;

/// A type and all types reached from it.
pub(crate) struct Graph {
    pub(crate) table: Arc<TypeTable>,
    nodes: Vec<Node>,
}

/// One type of a graph.
pub(crate) struct Node {
    /// The type as written: typedefs are kept.
    pub(crate) id: TypeId,
    /// Its IDL spelling.
    pub(crate) name: String,
    /// What it is made of, typedefs followed.
    pub(crate) shape: Shape,
    pub(crate) layout: Layout,
    /// Contains bounded sequences by value: `_maximum` must be set in new memory.
    pub(crate) bounded: bool,
    /// Not all bytes are valid values: contains booleans, enums, lengths or unions by value.
    pub(crate) checked: bool,
    /// Number of values contained by value. Limited, because [`MAX_SIZE`](crate::MAX_SIZE) does not
    /// limit loops over elements of size 0.
    count: usize,
    /// Least size of a value in CDR in bytes, without padding.
    pub(crate) least_wire: usize,
    pub(crate) digest: OnceLock<String>,
    pub(crate) fingerprint: OnceLock<Option<String>>,
    /// Plan for CDR in native byte order; made on first use.
    pub(crate) plan: OnceLock<CdrPlan>,
    /// Plan for reading CDR in the other byte order; made on first use.
    pub(crate) swapped: OnceLock<CdrPlan>,
}

/// What a type is made of.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Scalar(Scalar),
    Enum { scope: ScopedName, names: Vec<String> },
    Text { bound: Option<usize> },
    Array { element: Ix, length: usize },
    Sequence { element: Ix, bound: Option<usize> },
    Optional { element: Ix },
    Struct { members: Vec<Part> },
    Union { switch: Ix, members: Vec<Part>, cases: Vec<(i128, usize)>, default: Option<usize> },
    Native,
}

impl Shape {
    /// Whether JSON has `null` for a value of it.
    pub(crate) fn reads_as_null(&self) -> bool {
        matches!(
            self,
            Shape::Scalar(Scalar::Float | Scalar::Double) | Shape::Optional { .. } | Shape::Native
        )
    }
}

/// A member and its offset.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) ix: Ix,
    pub(crate) offset: usize,
}

/// Types that are one C arithmetic type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    Boolean,
    Char,
    Octet,
    Short,
    UnsignedShort,
    Long,
    UnsignedLong,
    LongLong,
    UnsignedLongLong,
    Float,
    Double,
}

impl Scalar {
    pub(crate) fn size(self) -> usize {
        match self {
            Scalar::Boolean | Scalar::Char | Scalar::Octet => 1,
            Scalar::Short | Scalar::UnsignedShort => 2,
            Scalar::Long | Scalar::UnsignedLong | Scalar::Float => 4,
            Scalar::LongLong | Scalar::UnsignedLongLong | Scalar::Double => 8,
        }
    }
}

impl Shape {
    /// The union member selected by a discriminant.
    pub(crate) fn selected(&self, switch: i128) -> Option<usize> {
        match self {
            Shape::Union { cases, default, .. } => cases
                .iter()
                .find_map(|&(value, member)| (value == switch).then_some(member))
                .or(*default),
            _ => None,
        }
    }
}

impl Graph {
    /// Lays out a type and all types it refers to; the type itself is [`Graph::ROOT`].
    pub(crate) fn new(table: &Arc<TypeTable>, id: TypeId) -> Result<Self, LayoutError> {
        let mut builder =
            Builder { table, slots: Vec::new(), known: HashMap::new(), todo: Vec::new() };
        builder.later(id);
        while let Some(ix) = builder.todo.pop() {
            builder.now(ix, 0)?;
        }
        let nodes: Vec<Node> = builder
            .slots
            .into_iter()
            .filter_map(|slot| match slot {
                Slot::Done(node) => Some(*node),
                Slot::Open(_) | Slot::Waiting(_) => None,
            })
            .collect();
        for node in &nodes {
            if let Shape::Sequence { element, .. } = node.shape
                && nodes[element.0 as usize].layout.size == 0
            {
                return Err(LayoutError::EmptyElement { name: node.name.clone() });
            }
        }
        Ok(Self { table: Arc::clone(table), nodes })
    }

    pub(crate) const ROOT: Ix = Ix(0);

    /// All its nodes.
    pub(crate) fn all(&self) -> impl Iterator<Item = Ix> {
        (0u32..).map(Ix).take(self.nodes.len())
    }

    pub(crate) fn node(&self, ix: Ix) -> &Node {
        &self.nodes[ix.0 as usize]
    }
}

enum Slot {
    /// Referred to; its layout has not begun.
    Waiting(TypeId),
    /// Being laid out: when it is met again, the type contains itself.
    Open(TypeId),
    Done(Box<Node>),
}

struct Builder<'a> {
    table: &'a TypeTable,
    slots: Vec<Slot>,
    known: HashMap<TypeId, Ix>,
    /// Elements of unbounded sequences, laid out last: the layout of a sequence does not need
    /// theirs.
    todo: Vec<Ix>,
}

/// Properties of a type, accumulated over its members.
struct Sum {
    bounded: bool,
    checked: bool,
    count: usize,
    least_wire: usize,
}

impl Sum {
    const ONE: Sum = Sum { bounded: false, checked: false, count: 1, least_wire: 0 };

    fn wire(least_wire: usize) -> Self {
        Self { least_wire, ..Self::ONE }
    }

    fn add(&mut self, node: &Node) {
        self.bounded |= node.bounded;
        self.checked |= node.checked;
        self.count = self.count.saturating_add(node.count);
        self.least_wire = self.least_wire.saturating_add(node.least_wire);
    }
}

impl Builder<'_> {
    /// The node of a type that may be laid out later.
    fn later(&mut self, id: TypeId) -> Ix {
        if let Some(&ix) = self.known.get(&id) {
            return ix;
        }
        let ix = Ix(u32::try_from(self.slots.len()).unwrap_or(u32::MAX));
        self.slots.push(Slot::Waiting(id));
        self.known.insert(id, ix);
        self.todo.push(ix);
        ix
    }

    /// The node of a type that another holds by value.
    fn value(&mut self, id: TypeId, depth: usize) -> Result<Ix, LayoutError> {
        let ix = self.later(id);
        self.now(ix, depth)?;
        Ok(ix)
    }

    fn done(&self, ix: Ix) -> Result<&Node, LayoutError> {
        match &self.slots[ix.0 as usize] {
            Slot::Done(node) => Ok(node),
            Slot::Open(id) | Slot::Waiting(id) => {
                Err(LayoutError::Recursive { name: self.table.spelling(*id) })
            }
        }
    }

    fn now(&mut self, ix: Ix, depth: usize) -> Result<(), LayoutError> {
        let Slot::Waiting(id) = self.slots[ix.0 as usize] else {
            return self.done(ix).map(|_| ());
        };
        if depth >= MAX_NESTING {
            return Err(LayoutError::TooDeep { name: self.table.spelling(id) });
        }
        self.slots[ix.0 as usize] = Slot::Open(id);
        let (shape, layout, sum) = self.lay_out(id, depth)?;
        let too_large = || LayoutError::TooLarge { name: self.table.spelling(id) };
        let layout = layout.ok_or_else(too_large)?;
        if sum.count > MAX_SIZE {
            return Err(too_large());
        }
        let node = Node {
            id,
            name: self.table.spelling(id),
            shape,
            layout,
            bounded: sum.bounded,
            checked: sum.checked,
            count: sum.count,
            least_wire: sum.least_wire,
            digest: OnceLock::new(),
            fingerprint: OnceLock::new(),
            plan: OnceLock::new(),
            swapped: OnceLock::new(),
        };
        self.slots[ix.0 as usize] = Slot::Done(Box::new(node));
        Ok(())
    }

    /// Shape, layout (`None`: too large) and accumulated properties of a type.
    fn lay_out(
        &mut self,
        id: TypeId,
        depth: usize,
    ) -> Result<(Shape, Option<Layout>, Sum), LayoutError> {
        let table = self.table;
        let scalar = |scalar: Scalar| {
            let size = scalar.size();
            let checked = scalar == Scalar::Boolean;
            let sum = Sum { checked, ..Sum::wire(size) };
            Ok((Shape::Scalar(scalar), Some(Layout::scalar(size)), sum))
        };
        match table.resolved(id) {
            Kind::Boolean => scalar(Scalar::Boolean),
            Kind::Char => scalar(Scalar::Char),
            Kind::Octet => scalar(Scalar::Octet),
            Kind::Short => scalar(Scalar::Short),
            Kind::UnsignedShort => scalar(Scalar::UnsignedShort),
            Kind::Long => scalar(Scalar::Long),
            Kind::UnsignedLong => scalar(Scalar::UnsignedLong),
            Kind::LongLong => scalar(Scalar::LongLong),
            Kind::UnsignedLongLong => scalar(Scalar::UnsignedLongLong),
            Kind::Float => scalar(Scalar::Float),
            Kind::Double => scalar(Scalar::Double),
            Kind::Enum { name, enumerators } => {
                let mut scope = name.segments().to_vec();
                // genom3.md 4.2: enumerators belong to the scope that contains the enum.
                scope.pop();
                let shape =
                    Shape::Enum { scope: ScopedName::new(scope), names: enumerators.clone() };
                let sum = Sum { checked: true, ..Sum::wire(4) };
                Ok((shape, Some(Layout::scalar(4)), sum))
            }
            Kind::String { bound: None } => {
                Ok((Shape::Text { bound: None }, Some(Layout::pointer()), Sum::wire(4)))
            }
            Kind::String { bound: Some(bound) } => {
                let bound = *bound as usize;
                Ok((Shape::Text { bound: Some(bound) }, Layout::text(bound), Sum::wire(4)))
            }
            Kind::Native { .. } => Ok((Shape::Native, Some(Layout::pointer()), Sum::wire(0))),
            Kind::Sequence { element, bound: None } => {
                let element = self.later(*element);
                let shape = Shape::Sequence { element, bound: None };
                Ok((shape, Some(Layout::unbounded_sequence()), Sum::wire(4)))
            }
            Kind::Sequence { element, bound: Some(bound) } => {
                let (element, bound) = (self.value(*element, depth + 1)?, *bound as usize);
                let inner = self.done(element)?;
                let sum = Sum {
                    bounded: true,
                    checked: true,
                    count: inner.count.saturating_mul(bound).saturating_add(1),
                    least_wire: 4,
                };
                let layout = Layout::bounded_sequence(&inner.layout, bound);
                Ok((Shape::Sequence { element, bound: Some(bound) }, layout, sum))
            }
            Kind::Array { element, length } => {
                let (element, length) = (self.value(*element, depth + 1)?, *length as usize);
                let inner = self.done(element)?;
                let sum = Sum {
                    bounded: inner.bounded && length > 0,
                    checked: inner.checked && length > 0,
                    count: inner.count.saturating_mul(length).max(1),
                    least_wire: inner.least_wire.saturating_mul(length),
                };
                let layout = Layout::array(&inner.layout, length);
                Ok((Shape::Array { element, length }, layout, sum))
            }
            Kind::Optional { element } => {
                let element = self.value(*element, depth + 1)?;
                let inner = self.done(element)?;
                // Offsets: those of `_present` and `_value`, the first is 0.
                let layout = Layout::sequential([&Layout::scalar(1), &inner.layout]);
                let layout = layout.map(|mut layout| {
                    layout.offsets.remove(0);
                    layout
                });
                let mut sum = Sum { checked: true, ..Sum::ONE };
                sum.add(inner);
                sum.least_wire = 4;
                Ok((Shape::Optional { element }, layout, sum))
            }
            Kind::Exception { name, members } if members.is_empty() => {
                Err(LayoutError::Void { name: name.to_string() })
            }
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                let mut sum = Sum::ONE;
                let parts = self.parts(members, depth, &mut sum)?;
                let layouts: Result<Vec<_>, _> =
                    parts.iter().map(|part| Ok(&self.done(part.ix)?.layout)).collect();
                let layout = Layout::sequential(layouts?);
                let mut members = parts;
                for (part, &offset) in
                    members.iter_mut().zip(layout.iter().flat_map(|l| &l.offsets))
                {
                    part.offset = offset;
                }
                Ok((Shape::Struct { members }, layout, sum))
            }
            Kind::Union { name, discriminant, members } => {
                let switch = self.value(*discriminant, depth + 1)?;
                let plain: Vec<Member> =
                    members.iter().map(|m| Member { name: m.name.clone(), ty: m.ty }).collect();
                let mut sum = Sum { checked: true, ..Sum::ONE };
                let mut parts = self.parts(&plain, depth, &mut sum)?;
                let head = self.done(switch)?;
                if !is_discriminant(&head.shape) {
                    let found = head.name.clone();
                    return Err(LayoutError::Discriminant { name: name.to_string(), found });
                }
                sum.least_wire = head.least_wire + 4 * parts.len();
                let layouts: Result<Vec<_>, _> =
                    parts.iter().map(|part| Ok(&self.done(part.ix)?.layout)).collect();
                let body = Layout::overlaid(layouts?);
                let layout = Layout::sequential([&head.layout, &body]).map(|mut layout| {
                    layout.offsets.remove(0);
                    layout
                });
                let offset = layout.as_ref().map_or(0, |layout| layout.offsets[0]);
                parts.iter_mut().for_each(|part| part.offset = offset);
                let (mut cases, mut default) = (Vec::new(), None);
                for (rank, member) in members.iter().enumerate() {
                    for label in &member.labels {
                        match label {
                            Label::Value(value) => cases.push((*value, rank)),
                            Label::Default => default = Some(rank),
                        }
                    }
                }
                Ok((Shape::Union { switch, members: parts, cases, default }, layout, sum))
            }
            Kind::Any => Err(LayoutError::Any),
            Kind::Forward { name, .. } => Err(LayoutError::Incomplete { name: name.to_string() }),
            // A typedef of itself; the table never resolves to any other typedef.
            Kind::Typedef { name, .. } => Err(LayoutError::Recursive { name: name.to_string() }),
        }
    }

    /// Members of a struct or union, their offsets not yet known.
    fn parts(
        &mut self,
        members: &[Member],
        depth: usize,
        sum: &mut Sum,
    ) -> Result<Vec<Part>, LayoutError> {
        let mut parts = Vec::with_capacity(members.len());
        for member in members {
            let ix = self.value(member.ty, depth + 1)?;
            sum.add(self.done(ix)?);
            parts.push(Part { name: member.name.clone(), ix, offset: 0 });
        }
        Ok(parts)
    }
}

fn is_discriminant(shape: &Shape) -> bool {
    match shape {
        Shape::Enum { .. } => true,
        Shape::Scalar(scalar) => !matches!(scalar, Scalar::Float | Scalar::Double),
        _ => false,
    }
}
