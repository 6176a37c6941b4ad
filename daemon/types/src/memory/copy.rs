//! Making, releasing and copying values, deep (genom3.md 7.9).

use std::ptr;

use crate::graph::{Graph, Ix, Shape};
use crate::memory::raw::{
    self, MAX_DEPTH, SequenceHeader, elements, free, give_back, integer, out_of_memory,
};

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
            // Elements too, though no values yet: codels raise `_length` and fill them.
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
        // Only the member in use: others overlap it.
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

/// Frees what a value owns; its pointers dangle afterwards.
///
/// # Safety
/// As [`release`]; the memory is overwritten before anybody reads it.
unsafe fn free_inside(graph: &Graph, ix: Ix, at: *mut u8, depth: usize) {
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
        // A native belongs to the codels: nobody else knows how to free it.
        Shape::Native | Shape::Scalar(_) | Shape::Enum { .. } => {}
    }
}

/// Makes one value equal to another; buffers of the target are reused where they are large
/// enough. Plain bytes are copied as they are, natives as pointers.
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
                let Some(target) = raw::resize(graph, (*element, *bound), to, length, depth) else {
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
                        // What an absent value holds is nobody's.
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
                // Zeros, not an empty union: that may hold `_maximum`s of another member.
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

/// Checks plain bytes that came from elsewhere as a value of a fixed-size type, and with `fix`
/// makes them one: booleans 0 or 1, `_maximum` as declared. Says where they are wrong.
///
/// # Safety
/// `at` has the size of the node, which is of fixed size; with `fix` it can be written.
pub(crate) unsafe fn repair(graph: &Graph, ix: Ix, at: *mut u8, fix: bool) -> Result<(), Ix> {
    let node = graph.node(ix);
    if !node.checked {
        return Ok(());
    }
    // SAFETY (all below): places inside the memory the caller vouches for.
    match &node.shape {
        Shape::Scalar(_) => {
            // Booleans: the only scalars that are checked.
            if fix {
                // SAFETY: as above.
                unsafe { at.write(u8::from(at.read() != 0)) };
            }
            Ok(())
        }
        Shape::Enum { names, .. } => {
            // SAFETY: as above.
            let value = unsafe { at.cast::<u32>().read_unaligned() };
            if (value as usize) < names.len() { Ok(()) } else { Err(ix) }
        }
        // SAFETY: as above.
        Shape::Sequence { element, bound: Some(bound) } => unsafe {
            if at.add(4).cast::<u32>().read_unaligned() as usize > *bound {
                return Err(ix);
            }
            if fix {
                at.cast::<u32>().write_unaligned(u32::try_from(*bound).unwrap_or(u32::MAX));
            }
            let (buffer, length) = elements(graph, *element, Some(*bound), at);
            repair_all(graph, *element, buffer, length, fix)
        },
        // SAFETY: as above.
        Shape::Array { element, length } => unsafe {
            repair_all(graph, *element, at, *length, fix)
        },
        // SAFETY: as above.
        Shape::Optional { element } => unsafe {
            if at.read() == 0 {
                return Ok(());
            }
            if fix {
                at.write(1);
            }
            repair(graph, *element, at.add(node.layout.offsets[0]), fix)
        },
        Shape::Struct { members } => members
            .iter()
            // SAFETY: as above.
            .try_for_each(|part| unsafe { repair(graph, part.ix, at.add(part.offset), fix) }),
        // SAFETY: as above.
        Shape::Union { switch, members, .. } => unsafe {
            repair(graph, *switch, at, fix)?;
            let value = integer(&graph.node(*switch).shape, at);
            match node.shape.selected(value).and_then(|rank| members.get(rank)) {
                Some(part) => repair(graph, part.ix, at.add(part.offset), fix),
                None => Ok(()),
            }
        },
        Shape::Sequence { bound: None, .. } | Shape::Text { .. } | Shape::Native => Ok(()),
    }
}

unsafe fn repair_all(
    graph: &Graph,
    element: Ix,
    at: *mut u8,
    length: usize,
    fix: bool,
) -> Result<(), Ix> {
    let node = graph.node(element);
    if !node.checked {
        return Ok(());
    }
    (0..length)
        // SAFETY: the caller's promise: `length` elements lie there.
        .try_for_each(|index| unsafe {
            repair(graph, element, at.add(index * node.layout.size), fix)
        })
}
