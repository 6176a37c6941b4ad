//! Checks bytes from elsewhere as values of fixed-size types.

use super::raw::{elements, integer};
use crate::graph::{Graph, Ix, Shape};

/// Checks bytes as a value of a fixed-size type; with `fix`, also normalises booleans to 0 or 1 and
/// sets `_maximum` as declared. The error is the node whose value is out of range.
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
            // Booleans are the only scalars that need a check.
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
