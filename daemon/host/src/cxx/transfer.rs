//! Copies values of types known at run time between C and C++. One of the few unsafe modules.
#![allow(unsafe_code)]

use genom_types::foreign;

use super::layout::{Graph, Part, Shape};
use super::life::{Vector, resize};
use super::shim;

/// Sequences nested deeper are not followed, as in C memory: a leak is better than a stack
/// overflow.
const MAX_DEPTH: usize = 256;

/// Number of valid elements of a bounded sequence.
///
/// # Safety
/// `at` holds such a sequence.
pub(super) unsafe fn bounded_length(at: *const u8, length_at: usize, bound: usize) -> usize {
    // SAFETY: the caller's promise.
    unsafe { at.add(length_at).cast::<usize>().read() }.min(bound)
}

/// Copies from C to C++.
///
/// # Safety
/// Both hold values of the node, in their languages, that nobody else uses meanwhile.
pub(super) unsafe fn read(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
    let node = &graph.nodes[ix];
    // SAFETY (all below): places inside values that the caller vouches for, by both layouts.
    if node.same {
        // SAFETY: as above; both are as large.
        unsafe { to.copy_from_nonoverlapping(from, node.size) };
        return;
    }
    let elements = |element: usize, from: *const u8, to: *mut u8, count: usize| {
        let inside = &graph.nodes[element];
        if inside.same {
            // SAFETY: as above.
            unsafe { to.copy_from_nonoverlapping(from, inside.size * count) };
            return;
        }
        let step = inside.c.size();
        for i in 0..count {
            // SAFETY: as above.
            unsafe { read(graph, element, from.add(i * step), to.add(i * inside.size), depth + 1) };
        }
    };
    match &node.shape {
        Shape::Plain => {}
        // SAFETY: as above.
        Shape::String => unsafe {
            let text = foreign::text_at(from);
            shim::genom_host_string_set(to, text.as_ptr(), text.len());
        },
        // SAFETY: as above.
        Shape::Flags => unsafe {
            let (first, length) = foreign::elements_at(&node.c, from);
            shim::genom_host_flags_set(to, first, length);
        },
        // SAFETY: as above.
        Shape::Vector { element } => unsafe {
            let (first, length) = foreign::elements_at(&node.c, from);
            let length = if depth < MAX_DEPTH { length } else { 0 };
            let begin = resize(graph, *element, to, length);
            if length > 0 {
                elements(*element, first, begin, length);
            }
        },
        // SAFETY: as above.
        Shape::Bounded { element, length_at, bound } => unsafe {
            let (first, length) = foreign::elements_at(&node.c, from);
            let length = length.min(*bound);
            elements(*element, first, to, length);
            to.add(*length_at).cast::<usize>().write(length);
        },
        Shape::Array { element, length } => elements(*element, from, to, *length),
        // SAFETY: as above; `_present` lies first in both.
        Shape::Optional { element, at, c_at } => unsafe {
            let present = from.read() != 0;
            to.write(present.into());
            if present {
                read(graph, *element, from.add(*c_at), to.add(*at), depth);
            }
        },
        Shape::Struct { parts } => {
            for Part { node, at, c_at } in parts {
                // SAFETY: as above.
                unsafe { read(graph, *node, from.add(*c_at), to.add(*at), depth) };
            }
        }
    }
}

/// Copies from C++ to C.
///
/// # Safety
/// As for [`read`].
pub(super) unsafe fn write(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
    let node = &graph.nodes[ix];
    // SAFETY (all below): places inside values that the caller vouches for, by both layouts.
    if node.same {
        // SAFETY: as above; both are as large.
        unsafe { to.copy_from_nonoverlapping(from, node.size) };
        return;
    }
    let elements = |element: usize, from: *const u8, to: *mut u8, count: usize| {
        let inside = &graph.nodes[element];
        if inside.same {
            // SAFETY: as above.
            unsafe { to.copy_from_nonoverlapping(from, inside.size * count) };
            return;
        }
        let step = inside.c.size();
        for i in 0..count {
            // SAFETY: as above.
            unsafe {
                write(graph, element, from.add(i * inside.size), to.add(i * step), depth + 1)
            };
        }
    };
    match &node.shape {
        Shape::Plain => {}
        // SAFETY: as above.
        Shape::String => unsafe { foreign::set_text_at(to, text(from)) },
        // SAFETY: as above.
        Shape::Flags => unsafe {
            let length = shim::genom_host_flags_length(from);
            if let Some(first) = foreign::resize_at(&node.c, to, length) {
                shim::genom_host_flags_get(from, first);
            }
        },
        // SAFETY: as above.
        Shape::Vector { element } => unsafe {
            let vector = from.cast::<Vector>().read();
            let length = vector.length(graph.nodes[*element].size);
            let length = if depth < MAX_DEPTH { length } else { 0 };
            match foreign::resize_at(&node.c, to, length) {
                Some(first) if length > 0 => elements(*element, vector.begin, first, length),
                Some(_) => {}
                None => tracing::error!("{}: no memory for {length} elements", node.c.name()),
            }
        },
        // SAFETY: as above.
        Shape::Bounded { element, length_at, bound } => unsafe {
            let length = bounded_length(from, *length_at, *bound);
            if let Some(first) = foreign::resize_at(&node.c, to, length) {
                elements(*element, from, first, length);
            }
        },
        Shape::Array { element, length } => elements(*element, from, to, *length),
        // SAFETY: as above. An absent value is made empty in C, so that nothing of it leaks.
        Shape::Optional { element, at, c_at } => unsafe {
            let present = from.read() != 0;
            if present {
                to.write(1);
                write(graph, *element, from.add(*at), to.add(*c_at), depth);
            } else {
                foreign::release_value(&node.c, to);
            }
        },
        Shape::Struct { parts } => {
            for Part { node, at, c_at } in parts {
                // SAFETY: as above.
                unsafe { write(graph, *node, from.add(*at), to.add(*c_at), depth) };
            }
        }
    }
}

/// Copies from C++ to C++.
///
/// # Safety
/// As for [`read`].
pub(super) unsafe fn assign(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
    let node = &graph.nodes[ix];
    // SAFETY (all below): places inside values that the caller vouches for.
    if node.same {
        // SAFETY: as above.
        unsafe { to.copy_from_nonoverlapping(from, node.size) };
        return;
    }
    let elements = |element: usize, from: *const u8, to: *mut u8, count: usize| {
        let size = graph.nodes[element].size;
        for i in 0..count {
            // SAFETY: as above.
            unsafe { assign(graph, element, from.add(i * size), to.add(i * size), depth + 1) };
        }
    };
    match &node.shape {
        Shape::Plain => {}
        // SAFETY: as above.
        Shape::String => unsafe {
            let text = text(from);
            shim::genom_host_string_set(to, text.as_ptr(), text.len());
        },
        // SAFETY: as above.
        Shape::Flags => unsafe {
            let mut bytes = vec![0_u8; shim::genom_host_flags_length(from)];
            shim::genom_host_flags_get(from, bytes.as_mut_ptr());
            shim::genom_host_flags_set(to, bytes.as_ptr(), bytes.len());
        },
        // SAFETY: as above.
        Shape::Vector { element } => unsafe {
            let vector = from.cast::<Vector>().read();
            let length = vector.length(graph.nodes[*element].size);
            let length = if depth < MAX_DEPTH { length } else { 0 };
            let begin = resize(graph, *element, to, length);
            if length > 0 {
                elements(*element, vector.begin, begin, length);
            }
        },
        // SAFETY: as above.
        Shape::Bounded { element, length_at, bound } => unsafe {
            let length = bounded_length(from, *length_at, *bound);
            elements(*element, from, to, length);
            to.add(*length_at).cast::<usize>().write(length);
        },
        Shape::Array { element, length } => elements(*element, from, to, *length),
        // SAFETY: as above.
        Shape::Optional { element, at, .. } => unsafe {
            to.write(from.read());
            assign(graph, *element, from.add(*at), to.add(*at), depth);
        },
        Shape::Struct { parts } => {
            for Part { node, at, .. } in parts {
                // SAFETY: as above.
                unsafe { assign(graph, *node, from.add(*at), to.add(*at), depth) };
            }
        }
    }
}

/// The bytes of a `std::string`.
///
/// # Safety
/// `at` holds one that nobody changes while the slice is used.
unsafe fn text<'a>(at: *const u8) -> &'a [u8] {
    let mut length = 0;
    // SAFETY: the caller's promise; the shim returns the string's own buffer.
    unsafe {
        let first = shim::genom_host_string_get(at, &raw mut length);
        std::slice::from_raw_parts(first, length)
    }
}
