//! The flat list of steps that encodes and decodes a type.
//!
//! Adjacent members that look the same in memory and on the wire make one step. Padding is never
//! copied: its bytes are undefined.

use crate::cdr::step::{CdrPlan, Run, Step, What};
use crate::graph::{Graph, Ix, Scalar, Shape};

/// Arrays of up to that many structs are unrolled into the list.
const UNROLL: usize = 4;

/// The plan of a node. With `swap`, for the other byte order, each copying step holds scalars of
/// one size.
#[inline]
pub(crate) fn plan(graph: &Graph, ix: Ix, swap: bool) -> &CdrPlan {
    let node = graph.node(ix);
    let cell = if swap { &node.swapped } else { &node.plan };
    cell.get_or_init(|| {
        let mut builder = Builder { graph, swap, steps: Vec::new(), modulus: 1, phase: 0 };
        builder.add(ix, 0);
        CdrPlan { steps: builder.steps }
    })
}

/// Makes the plans of all nodes.
pub(crate) fn prepare(graph: &Graph) {
    graph.all().for_each(|ix| {
        plan(graph, ix, false);
    });
}

struct Builder<'a> {
    graph: &'a Graph,
    swap: bool,
    steps: Vec<Step>,
    /// What is known of the position on the wire: it is `phase` modulo `modulus`.
    modulus: usize,
    phase: usize,
}

impl Builder<'_> {
    /// Records an alignment; returns the one to apply at run time, 1 for none.
    fn align(&mut self, align: usize) -> usize {
        let known = align <= self.modulus;
        if known && self.phase.is_multiple_of(align) {
            return 1;
        }
        if known {
            self.phase = self.phase.next_multiple_of(align) % self.modulus;
        } else {
            (self.modulus, self.phase) = (align, 0);
        }
        align
    }

    fn advance(&mut self, bytes: usize) {
        self.phase = (self.phase + bytes) % self.modulus;
    }

    fn push(&mut self, ix: Ix, offset: usize, align: usize, what: What) {
        let align = self.align(align);
        self.steps.push(Step { offset, align, what, ix });
    }

    /// Adds a step after which the position on the wire is not known in advance.
    fn push_open(&mut self, ix: Ix, offset: usize, align: usize, what: What) {
        self.push(ix, offset, align, what);
        (self.modulus, self.phase) = (1, 0);
    }

    fn add(&mut self, ix: Ix, offset: usize) {
        let graph = self.graph;
        let node = graph.node(ix);
        match &node.shape {
            Shape::Scalar(Scalar::Boolean) => self.booleans(ix, offset, 1),
            Shape::Scalar(scalar) => self.copy(ix, offset, scalar.size(), scalar.size()),
            Shape::Enum { names, .. } => self.enums(ix, offset, 1, limit(names)),
            Shape::Text { bound } => {
                self.push_open(ix, offset, 4, What::Text { bound: *bound });
            }
            Shape::Array { length: 0, .. } => {}
            Shape::Array { element, length } => self.array(ix, *element, *length, offset),
            Shape::Sequence { element, bound } => {
                let (element, bound) = (*element, *bound);
                let run = run(graph, element, self.swap);
                self.push_open(ix, offset, 4, What::Sequence { element, bound, run });
            }
            Shape::Optional { element } => {
                let what = What::Optional { element: *element, value: node.layout.offsets[0] };
                self.push_open(ix, offset, 4, what);
            }
            Shape::Struct { members } => {
                for part in members {
                    self.add(part.ix, offset + part.offset);
                }
            }
            // The steps of the discriminant do the alignment.
            Shape::Union { .. } => self.push_open(ix, offset, 1, What::Union),
            Shape::Native => self.push_open(ix, offset, 1, What::Native),
        }
    }

    /// Scalars of one size, one after the other, joined to the step before if they touch it both
    /// in memory and on the wire.
    fn copy(&mut self, ix: Ix, offset: usize, bytes: usize, unit: usize) {
        let align = self.align(unit);
        self.advance(bytes);
        if align == 1
            && let Some(Step { offset: start, what: What::Copy { bytes: sum, unit: same }, .. }) =
                self.steps.last_mut()
            && *start + *sum == offset
            && (!self.swap || *same == unit)
        {
            *sum += bytes;
            return;
        }
        self.steps.push(Step { offset, align, what: What::Copy { bytes, unit }, ix });
    }

    fn booleans(&mut self, ix: Ix, offset: usize, count: usize) {
        self.push(ix, offset, 1, What::Booleans { count });
        self.advance(count);
    }

    fn enums(&mut self, ix: Ix, offset: usize, count: usize, limit: u32) {
        self.push(ix, offset, 4, What::Enums { count, limit });
        self.advance(4 * count);
    }

    fn array(&mut self, ix: Ix, element: Ix, count: usize, offset: usize) {
        let size = self.graph.node(element).layout.size;
        match run(self.graph, element, self.swap) {
            Some(Run::Booleans) => self.booleans(ix, offset, count * size),
            Some(Run::Enums { limit }) => self.enums(ix, offset, count * size / 4, limit),
            Some(Run::Copy { align, unit }) => {
                // Aligned as its first scalar; the rest follows without gaps.
                let aligned = self.align(align);
                if aligned == 1 {
                    self.copy_aligned(ix, offset, count * size, unit);
                } else {
                    let what = What::Copy { bytes: count * size, unit };
                    self.steps.push(Step { offset, align: aligned, what, ix });
                    self.advance(count * size);
                }
            }
            None if count <= UNROLL => {
                (0..count).for_each(|index| self.add(element, offset + index * size));
            }
            None => self.push_open(ix, offset, 1, What::Repeat { element, count }),
        }
    }

    fn copy_aligned(&mut self, ix: Ix, offset: usize, bytes: usize, unit: usize) {
        if let Some(Step { offset: start, what: What::Copy { bytes: sum, unit: same }, .. }) =
            self.steps.last_mut()
            && *start + *sum == offset
            && (!self.swap || *same == unit)
        {
            *sum += bytes;
        } else {
            self.steps.push(Step { offset, align: 1, what: What::Copy { bytes, unit }, ix });
        }
        self.advance(bytes);
    }
}

fn limit(names: &[String]) -> u32 {
    u32::try_from(names.len()).unwrap_or(u32::MAX)
}

/// How consecutive values of the type can be handled at once: `Some` when they are the same in
/// memory and on the wire, booleans and enums to be checked.
fn run(graph: &Graph, ix: Ix, swap: bool) -> Option<Run> {
    let node = graph.node(ix);
    match &node.shape {
        Shape::Scalar(Scalar::Boolean) => Some(Run::Booleans),
        Shape::Scalar(scalar) => Some(Run::Copy { align: scalar.size(), unit: scalar.size() }),
        Shape::Enum { names, .. } => Some(Run::Enums { limit: limit(names) }),
        Shape::Array { element, .. } if node.layout.size > 0 => run(graph, *element, swap),
        Shape::Struct { members } => {
            // In CDR a struct is aligned as its first scalar is, so that one has to be the widest;
            // and there must be no gap between members.
            let (mut end, mut first) = (0, None);
            for part in members {
                let size = graph.node(part.ix).layout.size;
                if part.offset != end {
                    return None;
                }
                if size == 0 {
                    continue;
                }
                let Some(Run::Copy { align, unit }) = run(graph, part.ix, swap) else {
                    return None;
                };
                let (widest, same) = *first.get_or_insert((align, unit));
                if align > widest || (swap && unit != same) {
                    return None;
                }
                end += size;
            }
            let (align, unit) = first?;
            (end == node.layout.size).then_some(Run::Copy { align, unit })
        }
        _ => None,
    }
}
