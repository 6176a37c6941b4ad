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

    /// Node of the elements of an array or sequence, address of the first, and how many there are.
    fn row(self) -> (Ix, *const u8, usize) {
        match self.node().shape {
            Shape::Array { element, length } => (element, self.at, length),
            Shape::Sequence { element, bound } => {
                // SAFETY: this is a value of that shape.
                let (buffer, length) =
                    unsafe { raw::elements(self.graph, element, bound, self.at) };
                (element, buffer.cast_const(), length)
            }
            _ => (self.ix, self.at, 0),
        }
    }

    /// Elements of an array or sequence.
    pub(crate) fn elements(self) -> impl Iterator<Item = View<'a>> {
        let (element, at, length) = self.row();
        let size = self.graph.node(element).layout.size;
        // SAFETY: `length` elements are readable from `at`.
        (0..length)
            .map(move |index| unsafe { Self::new(self.graph, element, at.add(index * size)) })
    }

    /// An element of an array, or of a sequence if it is that long.
    pub(crate) fn element(self, index: usize) -> Option<View<'a>> {
        let (element, at, length) = self.row();
        let size = self.graph.node(element).layout.size;
        // SAFETY: `length` elements are readable from `at`.
        (index < length).then(|| unsafe { Self::new(self.graph, element, at.add(index * size)) })
    }

    /// The bytes of an array or sequence of octets.
    pub(crate) fn octets(self) -> Option<&'a [u8]> {
        let (element, at, length) = self.row();
        let octets = matches!(self.node().shape, Shape::Array { .. } | Shape::Sequence { .. })
            && matches!(self.graph.node(element).shape, Shape::Scalar(Scalar::Octet));
        match (octets, length) {
            (false, _) => None,
            (true, 0) => Some(&[]),
            // SAFETY: `length` octets are readable from `at`, and nobody writes them during 'a.
            (true, _) => Some(unsafe { std::slice::from_raw_parts(at, length) }),
        }
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

    /// A member of a struct by its place; of a union only while it is the selected one.
    pub(crate) fn member(self, index: usize) -> Option<View<'a>> {
        let part = match &self.node().shape {
            Shape::Struct { members } => members.get(index)?,
            shape @ Shape::Union { members, .. }
                if shape.selected(self.switch()?.integer()) == Some(index) =>
            {
                members.get(index)?
            }
            _ => return None,
        };
        Some(self.inside(part.ix, part.offset))
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
