//! What C code calls with arguments that are read at run time: a callback, and its data. One of the
//! few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::marker::PhantomData;

/// Implementation of a native function: gets its data and its arguments, returns a pointer.
pub(crate) type Callback<T> = fn(&T, Arguments<'_>) -> *const c_void;

/// A callback and its data.
pub(super) struct Bound<T> {
    callback: Callback<T>,
    data: T,
}

impl<T> Bound<T> {
    pub(super) const fn new(callback: Callback<T>, data: T) -> Self {
        Self { callback, data }
    }

    /// Unwinding into C would abort the daemon: returns a null event or datum instead.
    pub(super) fn run(&self, arguments: Arguments<'_>) -> *const c_void {
        let run = || (self.callback)(&self.data, arguments);
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_or_else(|_| {
            tracing::error!("a method of a port or remote panicked");
            std::ptr::null()
        })
    }
}

/// The arguments of one call from C.
#[derive(Clone, Copy)]
pub(crate) struct Arguments<'call> {
    at: *const *const c_void,
    _call: PhantomData<&'call ()>,
}

impl<'call> Arguments<'call> {
    /// Arguments whose addresses are at `at`.
    ///
    /// # Safety
    /// There is one for each argument that the callback uses, and they stay for the call.
    pub(super) unsafe fn at(at: *const *const c_void) -> Self {
        Self { at, _call: PhantomData }
    }

    /// Address of the value of argument `index`.
    pub(crate) fn place(self, index: usize) -> *const u8 {
        // SAFETY: callbacks use arguments of their own interface only.
        unsafe { self.at.add(index).read().cast() }
    }

    /// Argument `index`, of class `Held` or `Address`.
    pub(crate) fn pointer(self, index: usize) -> *mut u8 {
        // SAFETY: such an argument is a pointer.
        unsafe { self.place(index).cast::<*mut u8>().read() }
    }

    /// Argument `index`, a C string; `None` for NULL or more than `limit` bytes.
    pub(crate) fn text(self, index: usize, limit: usize) -> Option<&'call [u8]> {
        let text = self.pointer(index).cast::<c_char>();
        if text.is_null() {
            return None;
        }
        for length in 0..=limit {
            // SAFETY: the codel passed a NUL-terminated string; no byte after the NUL is read.
            let (byte, bytes) = unsafe {
                (text.add(length).read(), std::slice::from_raw_parts(text.cast::<u8>(), length))
            };
            if byte == 0 {
                return Some(bytes);
            }
        }
        None
    }
}
