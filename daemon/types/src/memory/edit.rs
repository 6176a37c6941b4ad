//! Changing a value: a node and an address; safe to use once it is made.

use std::marker::PhantomData;

use super::copy::set_text;
use super::life::{init, release};
use super::raw::elements;
use super::resize::resize;
use super::view::View;
use crate::graph::{Graph, Ix, Node, Scalar, Shape};

/// A value in memory, borrowed exclusively. Methods that do not apply to the value's shape do
/// nothing.
pub(crate) struct Edit<'a> {
    graph: &'a Graph,
    ix: Ix,
    at: *mut u8,
    memory: PhantomData<&'a mut u8>,
}

impl<'a> Edit<'a> {
    /// # Safety
    /// `at` holds a value of that node that nobody else uses during `'a`.
    pub(crate) unsafe fn new(graph: &'a Graph, ix: Ix, at: *mut u8) -> Self {
        Self { graph, ix, at, memory: PhantomData }
    }

    /// A discriminant in a word of its own, outside any value, to be read into.
    pub(crate) fn scratch(graph: &'a Graph, ix: Ix, word: &'a mut u64) -> Self {
        debug_assert!(graph.node(ix).layout.size <= 8 && graph.node(ix).layout.fixed);
        // SAFETY: a discriminant is at most a word (checked when the union was laid out), and
        // any word is a value of it for us.
        unsafe { Self::new(graph, ix, std::ptr::from_mut(word).cast()) }
    }

    pub(crate) fn node(&self) -> &'a Node {
        self.graph.node(self.ix)
    }

    pub(crate) fn graph(&self) -> &'a Graph {
        self.graph
    }

    pub(crate) fn view(&self) -> View<'_> {
        // SAFETY: this is a value of that node, borrowed while the view lives.
        unsafe { View::new(self.graph, self.ix, self.at) }
    }

    fn inside(&mut self, ix: Ix, offset: usize) -> Edit<'_> {
        // SAFETY: offsets come from the layout of this value or the length of a sequence, so a
        // value of that node lies there; it is borrowed from this one.
        unsafe { Edit::new(self.graph, ix, self.at.add(offset)) }
    }

    /// Sets a boolean, char, integer or enumerator's rank; the caller checked the range.
    pub(crate) fn set_integer(&mut self, value: i128) {
        use Scalar as S;
        // SAFETY (each arm): this is a value of that shape. `as` keeps the low bits, and the
        // value fits.
        match self.node().shape {
            // SAFETY: as above.
            Shape::Enum { .. } | Shape::Scalar(S::UnsignedLong | S::Long) => unsafe {
                self.at.cast::<u32>().write(value as u32);
            },
            // SAFETY: as above.
            Shape::Scalar(S::Boolean | S::Char | S::Octet) => unsafe {
                self.at.write(value as u8);
            },
            // SAFETY: as above.
            Shape::Scalar(S::Short | S::UnsignedShort) => unsafe {
                self.at.cast::<u16>().write(value as u16);
            },
            // SAFETY: as above.
            Shape::Scalar(S::LongLong | S::UnsignedLongLong) => unsafe {
                self.at.cast::<u64>().write(value as u64);
            },
            _ => {}
        }
    }

    /// Sets a float (rounded) or double.
    pub(crate) fn set_real(&mut self, value: f64) {
        match self.node().shape {
            // SAFETY: this is a value of that shape.
            Shape::Scalar(Scalar::Float) => unsafe { self.at.cast::<f32>().write(value as f32) },
            // SAFETY: this is a value of that shape.
            Shape::Scalar(Scalar::Double) => unsafe { self.at.cast::<f64>().write(value) },
            _ => {}
        }
    }

    /// Sets a string; `text` is without NUL and within the bound.
    pub(crate) fn set_text(&mut self, text: &[u8]) {
        if let Shape::Text { bound } = self.node().shape {
            // SAFETY: this is a value of that shape.
            unsafe { set_text(self.at, bound, text) };
        }
    }

    /// Resizes a sequence, within its bound: the first elements stay, new ones are empty. `false`
    /// when there is no memory.
    pub(crate) fn resize(&mut self, length: usize) -> bool {
        match self.node().shape {
            // SAFETY: this is a value of that shape.
            Shape::Sequence { element, bound } => unsafe {
                resize(self.graph, (element, bound), self.at, length, 0).is_some()
            },
            _ => false,
        }
    }

    /// Number of elements of an array or sequence.
    pub(crate) fn length(&self) -> usize {
        match self.node().shape {
            Shape::Array { length, .. } => length,
            Shape::Sequence { element, bound } => {
                // SAFETY: this is a value of that shape.
                unsafe { elements(self.graph, element, bound, self.at).1 }
            }
            _ => 0,
        }
    }

    /// An element of an array or sequence.
    pub(crate) fn element(&mut self, index: usize) -> Option<Edit<'_>> {
        if index >= self.length() {
            return None;
        }
        let (element, first) = match self.node().shape {
            Shape::Array { element, .. } => (element, self.at),
            // SAFETY: this is a value of that shape.
            Shape::Sequence { element, bound } => unsafe {
                (element, elements(self.graph, element, bound, self.at).0)
            },
            _ => return None,
        };
        let size = self.graph.node(element).layout.size;
        // SAFETY: the index is below the number of elements.
        Some(unsafe { Edit::new(self.graph, element, first.add(index * size)) })
    }

    /// Makes an optional absent.
    pub(crate) fn set_absent(&mut self) {
        if let Shape::Optional { .. } = self.node().shape {
            self.clear();
        }
    }

    /// Makes an optional present, with an empty value if it was absent; returns the value.
    pub(crate) fn set_present(&mut self) -> Option<Edit<'_>> {
        let Shape::Optional { element } = self.node().shape else { return None };
        if self.view().value().is_none() {
            // SAFETY: this is a value of that shape; an absent optional owns nothing.
            unsafe {
                std::ptr::write_bytes(self.at, 0, self.node().layout.size);
                init(self.graph, self.ix, self.at);
                self.at.write(1);
            }
        }
        let offset = self.node().layout.offsets[0];
        Some(self.inside(element, offset))
    }

    /// A member of a struct.
    pub(crate) fn member(&mut self, rank: usize) -> Option<Edit<'_>> {
        let Shape::Struct { members } = &self.node().shape else { return None };
        let part = members.get(rank)?;
        Some(self.inside(part.ix, part.offset))
    }

    /// Sets the discriminant of a union; the member in use is emptied when it changes.
    pub(crate) fn select(&mut self, value: i128) {
        let Shape::Union { switch, .. } = self.node().shape else { return };
        if self.view().switch().is_some_and(|old| old.integer() == value) {
            return;
        }
        self.clear();
        // SAFETY: the empty union owns nothing, but it may hold `_maximum`s of the member that
        // zero selects, where the new member has something else.
        unsafe { std::ptr::write_bytes(self.at, 0, self.node().layout.size) };
        self.inside(switch, 0).set_integer(value);
        // SAFETY: all behind the discriminant is zero.
        unsafe { init(self.graph, self.ix, self.at) };
    }

    /// The member of a union that its discriminant selects.
    pub(crate) fn active(&mut self) -> Option<Edit<'_>> {
        let shape = &self.node().shape;
        let Shape::Union { members, .. } = shape else { return None };
        let switch = self.view().switch()?.integer();
        let part = members.get(shape.selected(switch)?)?;
        Some(self.inside(part.ix, part.offset))
    }

    /// Releases what the value owns and makes it empty.
    pub(crate) fn clear(&mut self) {
        // SAFETY: this is a value of that node that nobody else uses.
        unsafe { release(self.graph, self.ix, self.at, 0) };
    }
}
