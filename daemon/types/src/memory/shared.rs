//! Finds memory that several values point to after a codel assigned one struct to another in C.

use std::collections::HashSet;

use super::raw::{MAX_DEPTH, SequenceHeader, elements, integer};
use crate::graph::{Graph, Ix, Shape};

/// Sets strings and sequences to null whose buffers are in `seen`, and adds the other buffers to
/// it.
///
/// # Safety
/// `at` holds a value of that node, and nobody uses it.
pub(crate) unsafe fn give_up(
    graph: &Graph,
    ix: Ix,
    at: *mut u8,
    seen: &mut HashSet<usize>,
    depth: usize,
) {
    let node = graph.node(ix);
    if node.layout.fixed || depth > MAX_DEPTH {
        return;
    }
    // SAFETY (all below): places inside the value the caller vouches for.
    match &node.shape {
        Shape::Text { .. } => {
            let place = at.cast::<*mut u8>();
            // SAFETY: a string that is not fixed is a pointer.
            unsafe {
                let text = place.read();
                if !text.is_null() && !seen.insert(text as usize) {
                    place.write(std::ptr::null_mut());
                }
            }
        }
        Shape::Sequence { element, bound } => {
            if bound.is_none() {
                let place = at.cast::<SequenceHeader>();
                // SAFETY: an unbounded sequence is this header; all zero is an empty one.
                unsafe {
                    let header = place.read();
                    if header.buffer.is_null() || header.lent() {
                        return;
                    }
                    if !seen.insert(header.buffer as usize) {
                        place.write_bytes(0, 1);
                        return;
                    }
                }
            }
            let size = graph.node(*element).layout.size;
            // SAFETY: as above.
            let (buffer, length) = unsafe { elements(graph, *element, *bound, at) };
            if !graph.node(*element).layout.fixed {
                for index in 0..length {
                    // SAFETY: elements below the length are values.
                    unsafe { give_up(graph, *element, buffer.add(index * size), seen, depth + 1) };
                }
            }
        }
        Shape::Array { element, length } => {
            let size = graph.node(*element).layout.size;
            for index in 0..*length {
                // SAFETY: as above.
                unsafe { give_up(graph, *element, at.add(index * size), seen, depth) };
            }
        }
        Shape::Optional { element } => {
            // SAFETY: as above; `_present` lies first.
            unsafe {
                if at.read() != 0 {
                    give_up(graph, *element, at.add(node.layout.offsets[0]), seen, depth);
                }
            }
        }
        Shape::Struct { members } => {
            for part in members {
                // SAFETY: as above.
                unsafe { give_up(graph, part.ix, at.add(part.offset), seen, depth) };
            }
        }
        Shape::Union { switch, members, .. } => {
            // SAFETY: as above; the discriminant lies first.
            let switch = unsafe { integer(&graph.node(*switch).shape, at) };
            if let Some(part) = node.shape.selected(switch).and_then(|rank| members.get(rank)) {
                // SAFETY: as above.
                unsafe { give_up(graph, part.ix, at.add(part.offset), seen, depth) };
            }
        }
        Shape::Native | Shape::Scalar(_) | Shape::Enum { .. } => {}
    }
}
