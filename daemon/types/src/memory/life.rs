//! Initialising and releasing values, deep (genom3.md 7.9).

use std::ptr;

use super::raw::{MAX_DEPTH, SequenceHeader, elements, free, give_back, integer};
use crate::graph::{Graph, Ix, Shape};

/// Makes zeroed memory a value: sets `_maximum` of bounded sequences.
///
/// # Safety
/// `at` is zeroed memory for that node.
pub(crate) unsafe fn init(graph: &Graph, ix: Ix, at: *mut u8) {
    let node = graph.node(ix);
    if !node.bounded {
        return;
    }
    // SAFETY (all below): places inside the memory the caller vouches for.
    match &node.shape {
        // SAFETY: as above.
        Shape::Sequence { element, bound: Some(bound) } => unsafe {
            at.cast::<u32>().write(u32::try_from(*bound).unwrap_or(u32::MAX));
            // Also elements beyond `_length`: codels raise it and fill them.
            if graph.node(*element).bounded {
                let (buffer, _) = elements(graph, *element, Some(*bound), at);
                let size = graph.node(*element).layout.size;
                (0..*bound).for_each(|index| init(graph, *element, buffer.add(index * size)));
            }
        },
        Shape::Array { element, length } => {
            let size = graph.node(*element).layout.size;
            // SAFETY: as above.
            (0..*length).for_each(|index| unsafe { init(graph, *element, at.add(index * size)) });
        }
        Shape::Optional { element } => {
            // SAFETY: as above.
            unsafe { init(graph, *element, at.add(node.layout.offsets[0])) };
        }
        Shape::Struct { members } => {
            for part in members {
                // SAFETY: as above.
                unsafe { init(graph, part.ix, at.add(part.offset)) };
            }
        }
        // Only the selected member: the others overlap it.
        Shape::Union { switch, members, .. } => {
            // SAFETY: as above; the discriminant lies first.
            let switch = unsafe { integer(&graph.node(*switch).shape, at) };
            if let Some(part) = node.shape.selected(switch).and_then(|rank| members.get(rank)) {
                // SAFETY: as above.
                unsafe { init(graph, part.ix, at.add(part.offset)) };
            }
        }
        _ => {}
    }
}

/// Releases what a value owns and makes it the empty value.
///
/// # Safety
/// `at` holds a value of that node, and nobody uses it.
pub(crate) unsafe fn release(graph: &Graph, ix: Ix, at: *mut u8, depth: usize) {
    // SAFETY: the caller's promise, passed on.
    unsafe {
        free_inside(graph, ix, at, depth);
        ptr::write_bytes(at, 0, graph.node(ix).layout.size);
        init(graph, ix, at);
    }
}

/// Frees the memory that a value owns; its pointers dangle afterwards.
///
/// # Safety
/// As [`release`]; the memory is overwritten before anybody reads it.
pub(super) unsafe fn free_inside(graph: &Graph, ix: Ix, at: *mut u8, depth: usize) {
    let node = graph.node(ix);
    if node.layout.fixed || depth > MAX_DEPTH {
        return;
    }
    // SAFETY (all below): places inside the value the caller vouches for.
    match &node.shape {
        // SAFETY: as above.
        Shape::Text { .. } => unsafe { free(at.cast::<*mut std::ffi::c_void>().read()) },
        Shape::Sequence { element, bound } => {
            // SAFETY: an unbounded sequence is this header.
            if bound.is_none() && unsafe { at.cast::<SequenceHeader>().read() }.lent() {
                return;
            }
            let size = graph.node(*element).layout.size;
            // SAFETY: as above.
            let (buffer, length) = unsafe { elements(graph, *element, *bound, at) };
            if !graph.node(*element).layout.fixed {
                for index in 0..length {
                    // SAFETY: elements below the length are values.
                    unsafe { free_inside(graph, *element, buffer.add(index * size), depth + 1) };
                }
            }
            if bound.is_none() {
                // SAFETY: an unbounded sequence is this header.
                unsafe { give_back(&at.cast::<SequenceHeader>().read()) };
            }
        }
        Shape::Array { element, length } => {
            let size = graph.node(*element).layout.size;
            for index in 0..*length {
                // SAFETY: as above.
                unsafe { free_inside(graph, *element, at.add(index * size), depth) };
            }
        }
        Shape::Optional { element } => {
            // SAFETY: as above; `_present` lies first.
            unsafe {
                if at.read() != 0 {
                    free_inside(graph, *element, at.add(node.layout.offsets[0]), depth);
                }
            }
        }
        Shape::Struct { members } => {
            for part in members {
                // SAFETY: as above.
                unsafe { free_inside(graph, part.ix, at.add(part.offset), depth) };
            }
        }
        Shape::Union { switch, members, .. } => {
            // SAFETY: as above; the discriminant lies first.
            let switch = unsafe { integer(&graph.node(*switch).shape, at) };
            if let Some(part) = node.shape.selected(switch).and_then(|rank| members.get(rank)) {
                // SAFETY: as above.
                unsafe { free_inside(graph, part.ix, at.add(part.offset), depth) };
            }
        }
        // A native belongs to the codels: only they know how to free it.
        Shape::Native | Shape::Scalar(_) | Shape::Enum { .. } => {}
    }
}
