//! Changing the length of sequences.

use super::life::{init, release};
use super::raw::{FREE, SequenceHeader, allocate, buffer_offset, give_back};
use crate::graph::{Graph, Ix};

/// Resizes a sequence to `length` elements: those beyond are released, new ones are empty. A buffer
/// that a codel lent is left alone, and the sequence gets a new one with empty elements. `None`
/// beyond the bound, or without memory (the sequence is then unchanged).
///
/// # Safety
/// `at` holds a sequence of that node.
pub(crate) unsafe fn resize(
    graph: &Graph,
    (element, bound): (Ix, Option<usize>),
    at: *mut u8,
    length: usize,
    depth: usize,
) -> Option<*mut u8> {
    let size = graph.node(element).layout.size;
    let new_length = u32::try_from(length).ok()?;
    // SAFETY (all below): the caller's promise, and offsets of the layout of genom3.md 5.2;
    // elements below `old` are values, memory up to the maximum belongs to the buffer.
    let (buffer, old) = match bound {
        Some(bound) if length > bound => return None,
        Some(bound) => {
            let layout = buffer_offset(graph, element);
            // SAFETY: a bounded sequence starts with two words, its buffer lies behind.
            unsafe {
                let old = (at.add(4).cast::<u32>().read() as usize).min(bound);
                (at.add(layout), old)
            }
        }
        None => {
            // SAFETY: an unbounded sequence is this header.
            let mut header = unsafe { at.cast::<SequenceHeader>().read() };
            if header.lent() {
                header = SequenceHeader {
                    maximum: 0,
                    length: 0,
                    buffer: std::ptr::null_mut(),
                    release: None,
                };
                // SAFETY: as above.
                unsafe { at.cast::<SequenceHeader>().write(header) };
            }
            let old = header.readable();
            let room = old.max(header.maximum as usize);
            if length > room || header.buffer.is_null() && length > 0 {
                let fresh = allocate(length, size)?;
                // SAFETY: both buffers have room for `old` elements; they move bit by bit.
                unsafe {
                    std::ptr::copy_nonoverlapping(header.buffer, fresh, old * size);
                    give_back(&header);
                }
                header = SequenceHeader {
                    maximum: new_length,
                    length: header.length,
                    buffer: fresh,
                    release: Some(FREE),
                };
                // SAFETY: as above.
                unsafe { at.cast::<SequenceHeader>().write(header) };
            }
            (header.buffer, old)
        }
    };
    for index in length..old {
        // SAFETY: elements below `old` are values.
        unsafe { release(graph, element, buffer.add(index * size), depth) };
    }
    if length > old {
        // SAFETY: the buffer has room for `length` elements; those from `old` on are no values.
        unsafe {
            std::ptr::write_bytes(buffer.add(old * size), 0, (length - old) * size);
            if graph.node(element).bounded {
                for index in old..length {
                    init(graph, element, buffer.add(index * size));
                }
            }
        }
    }
    // SAFETY: `_length` is the second word of both kinds.
    unsafe { at.add(4).cast::<u32>().write(new_length) };
    Some(buffer)
}
