//! Copying values, deep (genom3.md 7.9).

use std::ptr;

use super::life::{free_inside, init, release};
use super::raw::{self, MAX_DEPTH, elements, free, integer, out_of_memory};
use super::resize::resize;
use crate::graph::{Graph, Ix, Shape};

/// Makes one value equal to another, deep; buffers of the target are reused if they are large
/// enough. Fixed-size types are copied as bytes, natives as pointers.
///
/// # Safety
/// Both addresses hold values of that node and do not overlap.
pub(crate) unsafe fn copy(graph: &Graph, ix: Ix, from: *const u8, to: *mut u8, depth: usize) {
    let node = graph.node(ix);
    if node.layout.fixed {
        // SAFETY: the caller's promise.
        unsafe { ptr::copy_nonoverlapping(from, to, node.layout.size) };
        return;
    }
    // SAFETY (all below): places inside the values the caller vouches for.
    match &node.shape {
        // SAFETY: as above.
        Shape::Text { bound } => unsafe { set_text(to, *bound, raw::text(from, *bound)) },
        // SAFETY: as above.
        Shape::Native => unsafe { ptr::copy_nonoverlapping(from, to, node.layout.size) },
        Shape::Sequence { element, bound } => {
            let inner = graph.node(*element);
            // SAFETY: as above.
            unsafe {
                let (source, mut length) = elements(graph, *element, *bound, from);
                if depth >= MAX_DEPTH {
                    length = 0;
                }
                let size = inner.layout.size;
                let Some(target) = resize(graph, (*element, *bound), to, length, depth) else {
                    out_of_memory(length * size)
                };
                if length == 0 {
                } else if inner.layout.fixed {
                    ptr::copy_nonoverlapping(source, target, length * size);
                } else {
                    for offset in (0..length).map(|index| index * size) {
                        copy(graph, *element, source.add(offset), target.add(offset), depth + 1);
                    }
                }
            }
        }
        Shape::Array { element, length } => {
            let size = graph.node(*element).layout.size;
            for offset in (0..*length).map(|index| index * size) {
                // SAFETY: as above.
                unsafe { copy(graph, *element, from.add(offset), to.add(offset), depth) };
            }
        }
        // SAFETY: as above.
        Shape::Optional { element } => unsafe {
            let value = node.layout.offsets[0];
            match (from.read() != 0, to.read() != 0) {
                (false, true) => release(graph, ix, to, depth),
                (false, false) => {}
                (true, present) => {
                    if !present {
                        // The value part of an absent optional may hold anything and owns nothing.
                        ptr::write_bytes(to, 0, node.layout.size);
                        init(graph, ix, to);
                        to.write(1);
                    }
                    copy(graph, *element, from.add(value), to.add(value), depth);
                }
            }
        },
        Shape::Struct { members } => {
            for part in members {
                // SAFETY: as above.
                unsafe { copy(graph, part.ix, from.add(part.offset), to.add(part.offset), depth) };
            }
        }
        // SAFETY: as above.
        Shape::Union { switch, members, .. } => unsafe {
            let kind = graph.node(*switch);
            let value = integer(&kind.shape, from);
            if integer(&kind.shape, to) != value {
                // Zeros and not an empty union, which may hold `_maximum`s of another member.
                free_inside(graph, ix, to, depth);
                ptr::write_bytes(to, 0, node.layout.size);
                ptr::copy_nonoverlapping(from, to, kind.layout.size);
                init(graph, ix, to);
            }
            if let Some(part) = node.shape.selected(value).and_then(|rank| members.get(rank)) {
                copy(graph, part.ix, from.add(part.offset), to.add(part.offset), depth);
            }
        },
        Shape::Scalar(_) | Shape::Enum { .. } => {}
    }
}

/// Writes a string: a bounded one like strncpy (genom3.md 7.9), an unbounded one into its own
/// memory when that holds a string at least as long.
///
/// # Safety
/// `at` holds a `string` or `string<bound>`; `bytes` lie elsewhere.
pub(crate) unsafe fn set_text(at: *mut u8, bound: Option<usize>, bytes: &[u8]) {
    // SAFETY: the caller's promise; the array has `bound` bytes, an owned string has room for
    // the bytes it holds and a NUL.
    unsafe {
        if let Some(bound) = bound {
            let length = bytes.len().min(bound);
            ptr::copy_nonoverlapping(bytes.as_ptr(), at, length);
            ptr::write_bytes(at.add(length), 0, bound - length);
            return;
        }
        let slot = at.cast::<*mut u8>();
        let old = slot.read();
        if bytes.len() <= raw::text(at, None).len() && !old.is_null() {
            ptr::copy_nonoverlapping(bytes.as_ptr(), old, bytes.len());
            old.add(bytes.len()).write(0);
            return;
        }
        let Some(new) = raw::duplicate(bytes) else { out_of_memory(bytes.len()) };
        free(old.cast());
        slot.write(new);
    }
}
