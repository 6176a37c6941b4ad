//! Indices in 16 bits, for the tables that tasks read at each step.

use std::marker::PhantomData;

use genom_description::model::Ix;

/// An index of type `I` in a quarter of its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Ix16<I> {
    number: u16,
    index: PhantomData<fn(I) -> I>,
}

impl<I: Ix> Ix16<I> {
    /// The same index in 16 bits; `None` if it is above 65535.
    #[must_use]
    pub fn new(ix: I) -> Option<Self> {
        let number = u16::try_from(ix.index()).ok()?;
        Some(Self { number, index: PhantomData })
    }

    /// The index.
    #[must_use]
    #[inline]
    pub fn ix(self) -> I {
        I::new(usize::from(self.number))
    }
}
