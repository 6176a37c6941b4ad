//! Native types: values known to codels only. The IDS holds a pointer to them.

use std::ffi::CStr;
use std::fmt;

use super::{Data, named};
use crate::abi::{Kind, TypeDescriptor};

/// A Rust type that represents a `native` of the `.gen` file.
///
/// Codels that receive it run in several threads, but never at the same time.
pub trait NativeType: Send + 'static {
    /// Full name, such as `::demo::driver`.
    const NAME: &'static CStr;
}

/// A `native` in memory: a pointer that is null until a codel sets it.
///
/// The host does not know the value and never releases it. A codel has to take it back with
/// [`take`](Self::take), usually in state `stop`.
///
/// ```
/// use genom::{Event, Native, NativeType, event};
///
/// #[derive(NativeType)]
/// #[genom(name = "::demo::driver")]
/// struct Driver {
///     port: std::fs::File,
/// }
///
/// #[genom::codel]
/// fn demo_stop(driver: &mut Native<Driver>) -> Event {
///     drop(driver.take().map(|driver| driver.port)); // closes the file
///     event!("::demo::ether")
/// }
/// # fn main() {}
/// ```
#[repr(transparent)]
pub struct Native<T>(*mut T);

impl<T: NativeType> Native<T> {
    /// The value; `None` until a codel has set one.
    #[must_use]
    pub fn get(&self) -> Option<&T> {
        // SAFETY: null, or the box of `set`: only codels of this library write this pointer,
        // and the host lends it to one codel at a time (genom3.md 4.5).
        unsafe { self.0.as_ref() }
    }

    /// The value; `None` until a codel has set one.
    #[must_use]
    pub fn get_mut(&mut self) -> Option<&mut T> {
        // SAFETY: as in `get`, and `self` is borrowed exclusively.
        unsafe { self.0.as_mut() }
    }

    /// Sets the value, and drops the previous one.
    pub fn set(&mut self, value: T) {
        self.take();
        self.0 = Box::into_raw(Box::new(value));
    }

    /// Removes and returns the value.
    pub fn take(&mut self) -> Option<T> {
        let pointer = std::mem::replace(&mut self.0, std::ptr::null_mut());
        if pointer.is_null() {
            return None;
        }
        // SAFETY: not null, hence the box of `set`, which is forgotten here.
        Some(*unsafe { Box::from_raw(pointer) })
    }

    /// The pointer.
    pub(crate) fn as_ptr(&self) -> *const T {
        self.0
    }

    /// A copy of the pointer that a codel received as an `in` argument.
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
