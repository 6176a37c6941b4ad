//! Native types: values that only codels know; the IDS holds a pointer to them.

use std::ffi::CStr;
use std::fmt;

use super::{Data, named};
use crate::abi::{Kind, TypeDescriptor};

/// A Rust type that stands for a `native` of the `.gen` file.
///
/// It is shared by the codels that get it, which run in several threads, one at a time.
pub trait NativeType: Send + 'static {
    /// Full name, such as `::demo::driver`.
    const NAME: &'static CStr;
}

/// A `native` in memory: a pointer, null until a codel sets it.
///
/// The host does not know what it points to: a codel, usually that of state `stop`, takes the
/// value back, or it is never released.
#[repr(transparent)]
pub struct Native<T>(*mut T);

impl<T: NativeType> Native<T> {
    /// The value, once a codel has set one.
    #[must_use]
    pub fn get(&self) -> Option<&T> {
        // SAFETY: null, or the box of `set`: only codels of this library write this pointer,
        // and the host lends it to one codel at a time (genom3.md 4.5).
        unsafe { self.0.as_ref() }
    }

    /// The value, once a codel has set one.
    #[must_use]
    pub fn get_mut(&mut self) -> Option<&mut T> {
        // SAFETY: as in `get`, and `self` is borrowed exclusively.
        unsafe { self.0.as_mut() }
    }

    /// Replaces the value.
    pub fn set(&mut self, value: T) {
        self.take();
        self.0 = Box::into_raw(Box::new(value));
    }

    /// Takes the value back.
    pub fn take(&mut self) -> Option<T> {
        let pointer = std::mem::replace(&mut self.0, std::ptr::null_mut());
        if pointer.is_null() {
            return None;
        }
        // SAFETY: not null, hence the box of `set`, which is forgotten here.
        Some(*unsafe { Box::from_raw(pointer) })
    }

    /// The pointer itself.
    pub(crate) fn as_ptr(&self) -> *const T {
        self.0
    }

    /// A view of the pointer that a codel got as an `in` argument.
    pub(crate) fn view(pointer: *const T) -> Self {
        Self(pointer.cast_mut())
    }
}

impl<T> fmt::Debug for Native<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

// SAFETY: a native is a pointer in C, null when all bytes are zero.
unsafe impl<T: NativeType> Data for Native<T> {
    const TYPE: *const TypeDescriptor = &named::<Self>(Kind::NATIVE, T::NAME);
}
