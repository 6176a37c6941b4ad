//! Enums.

use std::fmt;
use std::marker::PhantomData;

use super::{Data, Scalar};
use crate::abi::TypeDescriptor;

/// An IDL enum. `#[derive(Data)]` implements the trait for a Rust enum with the same variants.
pub trait Enumeration: Copy + fmt::Debug + 'static {
    /// Descriptor of the type for the host.
    const TYPE: *const TypeDescriptor;

    /// The variant of this rank, counted from 0; `None` if there is none.
    fn from_rank(rank: u32) -> Option<Self>;

    /// The rank of this variant, from 0.
    fn rank(self) -> u32;
}

/// An enum in memory: C code may have put there a rank that no variant has.
///
/// ```
/// use genom::{Data, Enum};
///
/// #[derive(Clone, Copy, Debug, PartialEq, Data)]
/// #[genom(name = "::demo::gear")]
/// enum Gear {
///     Low,
///     High,
/// }
///
/// let mut gear = Enum::from(Gear::Low);
/// gear.set(Gear::High);
/// assert_eq!((gear.get(), gear.rank()), (Some(Gear::High), 1));
/// ```
#[derive(PartialEq, Eq)]
#[repr(transparent)]
pub struct Enum<E> {
    rank: u32,
    variants: PhantomData<E>,
}

impl<E: Enumeration> Enum<E> {
    /// The value, unless its rank is out of range.
    #[must_use]
    pub fn get(self) -> Option<E> {
        E::from_rank(self.rank)
    }

    /// Sets the value.
    pub fn set(&mut self, value: E) {
        self.rank = value.rank();
    }

    /// The number in memory.
    #[must_use]
    pub fn rank(self) -> u32 {
        self.rank
    }
}

impl<E> Clone for Enum<E> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E> Copy for Enum<E> {}

impl<E: Enumeration> From<E> for Enum<E> {
    fn from(value: E) -> Self {
        Self { rank: value.rank(), variants: PhantomData }
    }
}

impl<E: Enumeration> fmt::Debug for Enum<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.get() {
            Some(value) => value.fmt(f),
            None => write!(f, "<invalid {}>", self.rank),
        }
    }
}

// SAFETY: an enum is a uint32_t in C, and every number is accepted here.
unsafe impl<E: Enumeration> Data for Enum<E> {
    const TYPE: *const TypeDescriptor = E::TYPE;
}

impl<E: Enumeration> Scalar for Enum<E> {}
