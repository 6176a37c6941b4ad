//! Computes the size of a CDR payload before it is written.

use crate::cdr::encode::fitting;
use crate::cdr::plan::plan;
use crate::cdr::step::{Run, Step, What};
use crate::graph::{Graph, Ix, Shape};
use crate::layout::MAX_NESTING;
use crate::memory::{elements, integer, text};

/// Size of the payload of a value in bytes, if it can be encoded. Cheap where elements of sequences
/// are numbers or structs of numbers: only strings and what contains them are visited one by one.
///
/// # Safety
/// `at` holds a value of the node that nobody changes meanwhile.
pub(crate) unsafe fn size(graph: &Graph, ix: Ix, at: *const u8) -> usize {
    let mut ruler = Ruler { graph, length: 0 };
    // SAFETY: the caller's promise.
    unsafe { ruler.value(ix, at, 0) };
    ruler.length
}

struct Ruler<'a> {
    graph: &'a Graph,
    length: usize,
}

impl Ruler<'_> {
    fn put(&mut self, align: usize, bytes: usize) {
        self.length = self.length.next_multiple_of(align) + bytes;
    }

    /// # Safety
    /// As [`size`].
    unsafe fn value(&mut self, ix: Ix, at: *const u8, depth: usize) {
        for step in &plan(self.graph, ix, false).steps {
            // SAFETY: a plan's offsets lie inside the value, which holds what the step says.
            unsafe { self.step(step, at.add(step.offset), depth) };
        }
    }

    /// # Safety
    /// `at` holds what the step says.
    unsafe fn step(&mut self, step: &Step, at: *const u8, depth: usize) {
        let size_of = |ix: Ix| self.graph.node(ix).layout.size;
        // SAFETY (all below): the caller's promise, and lengths that `memory` vouches for.
        match step.what {
            What::Copy { bytes, .. } => self.put(step.align, bytes),
            What::Booleans { count } => self.put(1, count),
            What::Enums { count, .. } => self.put(step.align, 4 * count),
            What::Text { bound } => {
                // SAFETY: as above.
                let text = unsafe { text(at, bound) };
                self.put(step.align, 4 + fitting(text, bound) + 1);
            }
            What::Sequence { element, bound, run } => {
                // SAFETY: as above.
                let (buffer, length) = unsafe { elements(self.graph, element, bound, at) };
                let size = size_of(element);
                self.put(step.align, 4);
                match run {
                    _ if length == 0 => {}
                    Some(Run::Copy { align, .. }) => self.put(align, length * size),
                    Some(Run::Booleans) => self.put(1, length * size),
                    Some(Run::Enums { .. }) => self.put(1, length * size / 4 * 4),
                    // Refused by the encoder.
                    None if depth >= MAX_NESTING => {}
                    None => {
                        for index in 0..length {
                            // SAFETY: as above: `length` elements are values.
                            unsafe { self.value(element, buffer.add(index * size), depth + 1) };
                        }
                    }
                }
            }
            What::Repeat { element, count } => {
                let size = size_of(element);
                for index in 0..count {
                    // SAFETY: as above.
                    unsafe { self.value(element, at.add(index * size), depth) };
                }
            }
            What::Optional { element, value } => {
                self.put(step.align, 4);
                // SAFETY: as above; `_present` lies first.
                if unsafe { at.read() } != 0 {
                    // SAFETY: as above.
                    unsafe { self.value(element, at.add(value), depth) };
                }
            }
            What::Union => {
                let shape = &self.graph.node(step.ix).shape;
                let Shape::Union { switch, members, .. } = shape else { return };
                // SAFETY: as above; the discriminant lies first.
                let selected = unsafe {
                    self.value(*switch, at, depth);
                    shape.selected(integer(&self.graph.node(*switch).shape, at))
                };
                for (rank, part) in members.iter().enumerate() {
                    self.put(4, 4);
                    if selected == Some(rank) {
                        // SAFETY: the discriminant selects this member.
                        unsafe { self.value(part.ix, at.add(part.offset), depth) };
                    }
                }
            }
            // Refused by the encoder.
            What::Native => {}
        }
    }
}
