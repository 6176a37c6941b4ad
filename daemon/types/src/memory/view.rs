//! Reading a value: a node and an address; safe to use once it is made.

use std::marker::PhantomData;

use crate::graph::{Graph, Ix, Node, Scalar, Shape};
use crate::memory::raw;

/// A value in memory, borrowed. Methods that do not apply to the value's shape return something
/// empty.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) ix: Ix,
    at: *const u8,
    memory: PhantomData<&'a u8>,
}

impl<'a> View<'a> {
    /// # Safety
    /// `at` holds a value of that node that nobody writes during `'a`.
    pub(crate) unsafe fn new(graph: &'a Graph, ix: Ix, at: *const u8) -> Self {
        Self { graph, ix, at, memory: PhantomData }
    }

    pub(crate) fn node(self) -> &'a Node {
        self.graph.node(self.ix)
    }

    fn inside(self, ix: Ix, offset: usize) -> Self {
        // SAFETY: offsets come from the layout of this value or the readable length of a
        // sequence, so a value of that node lies there.
        unsafe { Self::new(self.graph, ix, self.at.add(offset)) }
    }

    /// Value of a boolean, char or integer, or rank of an enumerator.
    pub(crate) fn integer(self) -> i128 {
        // SAFETY: this is a value of that shape.
        unsafe { raw::integer(&self.node().shape, self.at) }
    }

    /// Value of a float (widened) or double.
    pub(crate) fn real(self) -> f64 {
        match self.node().shape {
            // SAFETY: this is a value of that shape.
            Shape::Scalar(Scalar::Float) => unsafe { self.at.cast::<f32>().read() }.into(),
            // SAFETY: this is a value of that shape.
            Shape::Scalar(Scalar::Double) => unsafe { self.at.cast::<f64>().read() },
            _ => 0.0,
        }
    }

    /// Bytes of a string, before its NUL.
    pub(crate) fn text(self) -> &'a [u8] {
        match self.node().shape {
            // SAFETY: this is a value of that shape, unchanged during 'a.
            Shape::Text { bound } => unsafe { raw::text(self.at, bound) },
            _ => &[],
        }
    }

    /// Elements of an array or sequence.
    pub(crate) fn elements(self) -> impl Iterator<Item = View<'a>> {
        let (element, at, length) = match self.node().shape {
            Shape::Array { element, length } => (element, self.at, length),
            Shape::Sequence { element, bound } => {
                // SAFETY: this is a value of that shape.
                let (buffer, length) =
                    unsafe { raw::elements(self.graph, element, bound, self.at) };
                (element, buffer.cast_const(), length)
            }
            _ => (self.ix, self.at, 0),
        };
        let size = self.graph.node(element).layout.size;
        // SAFETY: `length` elements are readable from `at`.
        (0..length)
            .map(move |index| unsafe { Self::new(self.graph, element, at.add(index * size)) })
    }

    /// The value of an optional, when present.
    pub(crate) fn value(self) -> Option<Self> {
        match self.node().shape {
            // SAFETY: `_present` lies first.
            Shape::Optional { element } if unsafe { self.at.read() } != 0 => {
                Some(self.inside(element, self.node().layout.offsets[0]))
            }
            _ => None,
        }
    }

    /// Members of a struct, with their names.
    pub(crate) fn members(self) -> impl Iterator<Item = (&'a str, View<'a>)> {
        let members = match &self.node().shape {
            Shape::Struct { members } => members.as_slice(),
            _ => &[],
        };
        members.iter().map(move |part| (part.name.as_str(), self.inside(part.ix, part.offset)))
    }

    /// The discriminant of a union.
    pub(crate) fn switch(self) -> Option<Self> {
        match self.node().shape {
            Shape::Union { switch, .. } => Some(self.inside(switch, 0)),
            _ => None,
        }
    }

    /// The selected member of a union, with its name.
    pub(crate) fn active(self) -> Option<(&'a str, View<'a>)> {
        let shape = &self.node().shape;
        let Shape::Union { members, .. } = shape else { return None };
        let part = members.get(shape.selected(self.switch()?.integer())?)?;
        Some((&part.name, self.inside(part.ix, part.offset)))
    }
}
