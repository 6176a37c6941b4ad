//! Booleans and numbers.

use std::fmt;

use super::{Data, plain};
use crate::abi::{Kind, TypeDescriptor};

/// A number. `in` parameters of this kind are passed by value.
pub trait Scalar: Data + Copy {}

macro_rules! scalars {
    ($($ty:ty: $kind:ident),*) => {$(
        // SAFETY: the C mapping is the fixed-width type of the same size and alignment, and
        // every bit pattern is a value.
        unsafe impl Data for $ty {
            const TYPE: *const TypeDescriptor =
                &plain::<Self>(Kind::$kind, 0, std::ptr::null());
        }

        impl Scalar for $ty {}
    )*};
}

scalars! {
    i8: CHAR, u8: OCTET, i16: SHORT, u16: UNSIGNED_SHORT, i32: LONG, u32: UNSIGNED_LONG,
    i64: LONG_LONG, u64: UNSIGNED_LONG_LONG, f32: FLOAT, f64: DOUBLE, Bool: BOOLEAN
}

/// A `boolean` in memory: any byte but 0 means true.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Bool(u8);

impl Bool {
    /// The value.
    #[must_use]
    pub const fn get(self) -> bool {
        self.0 != 0
    }

    /// Sets the value.
    pub const fn set(&mut self, value: bool) {
        self.0 = value as u8;
    }
}

impl From<bool> for Bool {
    fn from(value: bool) -> Self {
        Self(value.into())
    }
}

impl From<Bool> for bool {
    fn from(value: Bool) -> Self {
        value.get()
    }
}

impl PartialEq for Bool {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl Eq for Bool {}

impl fmt::Debug for Bool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}
