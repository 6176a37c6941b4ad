//! Optionals.

use std::fmt;

use super::{Aggregate, Bool, Data, plain};
use crate::abi::{Kind, TypeDescriptor};

/// `optional<T>`: memory for the value exists, and is initialised, even while the value is absent.
///
/// ```
/// use genom::Optional;
///
/// let mut speed = Optional::from(0.5);
/// speed.clear();
/// assert_eq!(speed.get(), None);
/// ```
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub struct Optional<T> {
    present: Bool,
    value: T,
}

impl<T> Optional<T> {
    /// The value, if present.
    #[must_use]
    pub fn get(&self) -> Option<&T> {
        self.present.get().then_some(&self.value)
    }

    /// The value, if present.
    #[must_use]
    pub fn get_mut(&mut self) -> Option<&mut T> {
        self.present.get().then_some(&mut self.value)
    }

    /// Sets the value.
    pub fn set(&mut self, value: T) {
        self.value = value;
        self.present.set(true);
    }

    /// Makes the value absent.
    pub fn clear(&mut self) {
        self.present.set(false);
    }
}

impl<T> From<T> for Optional<T> {
    fn from(value: T) -> Self {
        Self { present: true.into(), value }
    }
}

impl<T: PartialEq> PartialEq for Optional<T> {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl<T: fmt::Debug> fmt::Debug for Optional<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

// SAFETY: `struct { bool _present; T _value; }` in C; the host initialises absent values too.
unsafe impl<T: Data> Data for Optional<T> {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::OPTIONAL, 0, T::TYPE);
}

impl<T: Data> Aggregate for Optional<T> {}
