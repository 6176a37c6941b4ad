//! C++ values of types known at run time: made, dropped, and exchanged with values in C layout.
//! One of the few unsafe modules.
#![allow(unsafe_code)]

use std::fmt;

use genom_types::{Record, Room, Zones, foreign};

use super::layout::{CxxType, Graph, Part, Shape};
use super::shim;

/// Sequences in sequences that are followed, as in C memory: losing memory is better than losing
/// the stack.
const MAX_DEPTH: usize = 256;

/// An owned C++ value, at an address that never changes.
pub(crate) struct Object {
    ty: CxxType,
    room: Room,
}

// SAFETY: the value is the object's own; nothing in it belongs to a thread.
unsafe impl Send for Object {}
// SAFETY: with a shared reference the value is only read.
unsafe impl Sync for Object {}

impl fmt::Debug for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Object({})", self.ty.c().name())
    }
}

impl Object {
    /// An empty value: numbers are zero.
    pub(crate) fn new(ty: &CxxType) -> Self {
        let room = Room::new(ty.size());
        // SAFETY: fresh, zeroed memory of the type's size and alignment.
        unsafe { make(&ty.graph, ty.node, room.at()) };
        Self { ty: ty.clone(), room }
    }

    /// Its address.
    pub(crate) fn at(&self) -> *mut u8 {
        self.room.at()
    }

    /// Where the zones are that tell whether somebody wrote past the value.
    pub(crate) fn zones(&self) -> Zones {
        self.room.zones()
    }

    /// Its type.
    pub(crate) fn ty(&self) -> &CxxType {
        &self.ty
    }

    /// Makes it the empty value.
    pub(crate) fn clear(&mut self) {
        // SAFETY: the value is ours, and made anew after it was dropped.
        unsafe {
            drop_inside(&self.ty.graph, self.ty.node, self.room.at());
            self.room.at().write_bytes(0, self.ty.size());
            make(&self.ty.graph, self.ty.node, self.room.at());
        }
    }

    /// Takes the value of `from`, of the same type.
    pub(crate) fn set(&mut self, from: &Record) {
        // SAFETY: both hold values of the type, which is the callers' only one for both.
        unsafe { to_cxx(&self.ty, from.as_ptr(), self.room.at()) }
    }

    /// Gives its value to `to`, of the same type.
    pub(crate) fn get(&self, to: &mut Record) {
        // SAFETY: as above.
        unsafe { to_c(&self.ty, self.room.at(), to.as_mut_ptr()) }
    }
}

impl Drop for Object {
    fn drop(&mut self) {
        // SAFETY: it holds a value since it was made.
        unsafe { drop_inside(&self.ty.graph, self.ty.node, self.room.at()) }
    }
}

/// Makes the C++ value at `to` equal to the C value at `from`.
///
/// # Safety
/// Both hold values of the type, in their languages, that nobody else uses meanwhile.
pub(crate) unsafe fn to_cxx(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { read(&ty.graph, ty.node, from, to, 0) }
}

/// Makes the C value at `to` equal to the C++ value at `from`.
///
/// # Safety
/// As for [`to_cxx`].
pub(crate) unsafe fn to_c(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { write(&ty.graph, ty.node, from, to, 0) }
}

/// Makes one C++ value equal to another.
///
/// # Safety
/// As for [`to_cxx`].
pub(crate) unsafe fn copy(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { assign(&ty.graph, ty.node, from, to, 0) }
}

/// Makes an empty C++ value of the memory at `to`, then that of the C value at `from`.
///
/// # Safety
/// `to` is memory for the type, and `from` holds a value of it.
pub(super) unsafe fn construct(ty: &CxxType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe {
        to.write_bytes(0, ty.size());
        make(&ty.graph, ty.node, to);
        to_cxx(ty, from, to);
    }
}

/// Destroys the C++ value at `at`.
///
/// # Safety
/// `at` holds a value of the type, which is not used any more.
pub(super) unsafe fn destroy(ty: &CxxType, at: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { drop_inside(&ty.graph, ty.node, at) }
}

/// `std::vector<T>`: the shim checks that it is kept so.
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
unsafe fn make(graph: &Graph, node: usize, at: *mut u8) {
    let node = &graph.nodes[node];
    if node.same {
        return;
    }
    // SAFETY (all below): places inside the memory that the caller vouches for.
    match &node.shape {
        // Three null pointers are the empty vector.
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
unsafe fn drop_inside(graph: &Graph, node: usize, at: *mut u8) {
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

/// `resize(length)`, where elements may lose their value; gives their beginning.
///
/// # Safety
/// `at` holds a vector of such elements.
unsafe fn resize(graph: &Graph, element: usize, at: *mut u8, length: usize) -> *mut u8 {
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

/// The valid elements of a bounded sequence.
///
/// # Safety
/// `at` holds one.
pub(super) unsafe fn bounded_length(at: *const u8, length_at: usize, bound: usize) -> usize {
    // SAFETY: the caller's promise.
    unsafe { at.add(length_at).cast::<usize>().read() }.min(bound)
}

/// From C to C++.
///
/// # Safety
/// As for [`to_cxx`].
unsafe fn read(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
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

/// From C++ to C.
///
/// # Safety
/// As for [`to_c`].
unsafe fn write(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
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
        // SAFETY: as above. An absent value is empty in C, so that nothing of it leaks.
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

/// From C++ to C++.
///
/// # Safety
/// As for [`copy`].
unsafe fn assign(graph: &Graph, ix: usize, from: *const u8, to: *mut u8, depth: usize) {
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
/// `at` holds one, which nobody changes while the slice is used.
unsafe fn text<'a>(at: *const u8) -> &'a [u8] {
    let mut length = 0;
    // SAFETY: the caller's promise; the shim gives the string's own buffer.
    unsafe {
        let first = shim::genom_host_string_get(at, &raw mut length);
        std::slice::from_raw_parts(first, length)
    }
}
