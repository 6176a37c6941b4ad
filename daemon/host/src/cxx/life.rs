//! Constructing, resizing and destroying C++ values of types known at run time. One of the few
//! unsafe modules.
#![allow(unsafe_code)]

use super::layout::{Graph, Shape};
use super::shim;

/// Layout of `std::vector<T>`, which the shim verifies.
#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct Vector {
    pub(super) begin: *mut u8,
    pub(super) end: *mut u8,
    limit: *mut u8,
}

impl Vector {
    /// Number of elements of this size.
    pub(super) fn length(&self, size: usize) -> usize {
        (self.end as usize).saturating_sub(self.begin as usize) / size.max(1)
    }
}

/// Constructs an empty value.
///
/// # Safety
/// `at` is zeroed memory for the node.
pub(super) unsafe fn make(graph: &Graph, node: usize, at: *mut u8) {
    let node = &graph.nodes[node];
    if node.same {
        return;
    }
    // SAFETY (all below): places inside the memory that the caller vouches for.
    match &node.shape {
        // An empty vector is three null pointers.
        Shape::Plain | Shape::Vector { .. } => {}
        // SAFETY: as above.
        Shape::String => unsafe { shim::genom_host_string_make(at) },
        // SAFETY: as above.
        Shape::Flags => unsafe { shim::genom_host_flags_make(at) },
        Shape::Bounded { element, bound: count, .. } | Shape::Array { element, length: count } => {
            let size = graph.nodes[*element].size;
            // SAFETY: as above.
            (0..*count).for_each(|i| unsafe { make(graph, *element, at.add(i * size)) });
        }
        // SAFETY: as above.
        Shape::Optional { element, at: value, .. } => unsafe {
            make(graph, *element, at.add(*value));
        },
        Shape::Struct { parts } => {
            // SAFETY: as above.
            parts.iter().for_each(|part| unsafe { make(graph, part.node, at.add(part.at)) });
        }
    }
}

/// Destroys a value.
///
/// # Safety
/// `at` holds a value of the node, which is not used any more.
pub(super) unsafe fn drop_inside(graph: &Graph, node: usize, at: *mut u8) {
    let node = &graph.nodes[node];
    if node.same {
        return;
    }
    // SAFETY (all below): places inside the value that the caller vouches for.
    match &node.shape {
        Shape::Plain => {}
        // SAFETY: as above.
        Shape::String => unsafe { shim::genom_host_string_drop(at) },
        // SAFETY: as above.
        Shape::Flags => unsafe { shim::genom_host_flags_drop(at) },
        // SAFETY: as above; the buffer is one of `operator new`.
        Shape::Vector { element } => unsafe {
            let vector = at.cast::<Vector>().read();
            drop_elements(graph, *element, vector);
            shim::genom_host_storage_free(vector.begin);
        },
        Shape::Bounded { element, bound: count, .. } | Shape::Array { element, length: count } => {
            let size = graph.nodes[*element].size;
            // SAFETY: as above.
            (0..*count).for_each(|i| unsafe { drop_inside(graph, *element, at.add(i * size)) });
        }
        // SAFETY: as above.
        Shape::Optional { element, at: value, .. } => unsafe {
            drop_inside(graph, *element, at.add(*value));
        },
        Shape::Struct { parts } => {
            // SAFETY: as above.
            parts.iter().for_each(|p| unsafe { drop_inside(graph, p.node, at.add(p.at)) });
        }
    }
}

/// # Safety
/// The vector holds values of the node, which are not used any more.
unsafe fn drop_elements(graph: &Graph, element: usize, vector: Vector) {
    let inside = &graph.nodes[element];
    if !inside.same {
        for i in 0..vector.length(inside.size) {
            // SAFETY: elements below the length are values.
            unsafe { drop_inside(graph, element, vector.begin.add(i * inside.size)) };
        }
    }
}

/// As `resize(length)`, but elements may lose their values; returns the address of the first.
///
/// # Safety
/// `at` holds a vector of such elements.
pub(super) unsafe fn resize(graph: &Graph, element: usize, at: *mut u8, length: usize) -> *mut u8 {
    let size = graph.nodes[element].size;
    let place = at.cast::<Vector>();
    // SAFETY: the caller's promise; elements below the length are values, and memory up to the
    // limit belongs to the vector.
    unsafe {
        let mut vector = place.read();
        let mut old = vector.length(size);
        if length * size > (vector.limit as usize) - (vector.begin as usize) {
            drop_elements(graph, element, vector);
            shim::genom_host_storage_free(vector.begin);
            let begin = shim::genom_host_storage(length * size);
            vector = Vector { begin, end: begin, limit: begin.add(length * size) };
            old = 0;
        }
        let inside = &graph.nodes[element];
        if !inside.same {
            for i in length..old {
                drop_inside(graph, element, vector.begin.add(i * size));
            }
        }
        if length > old {
            vector.begin.add(old * size).write_bytes(0, (length - old) * size);
            (old..length).for_each(|i| make(graph, element, vector.begin.add(i * size)));
        }
        vector.end = vector.begin.wrapping_add(length * size);
        place.write(vector);
        vector.begin
    }
}
