//! C functions made at run time, each with its own data: the methods of ports and remotes, which do
//! not get their handle as an argument (genom3.md 5.7). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::fmt;
use std::marker::PhantomData;

use libffi::low;
use libffi::middle::Cif;

use super::{Class, Interface};
use crate::cxx::Raise;

/// Implementation of a native function: gets its data and its arguments, returns a pointer.
pub(crate) type Callback<T> = fn(&T, Arguments<'_>) -> *const c_void;

/// As [`Callback`], but returns an exception that the function throws, or null.
pub(crate) type Throwing<T> = fn(&T, Arguments<'_>) -> *const Raise;

/// A C function that calls `callback` with `data`.
pub(crate) struct NativeFunction {
    // Libffi keeps the addresses of both.
    _cif: Box<Cif>,
    _data: Box<dyn std::any::Any + Send + Sync>,
    closure: *mut low::ffi_closure,
    code: usize,
}

// SAFETY: after construction it is only called; the data that it passes to the callback is `Sync`.
unsafe impl Send for NativeFunction {}
// SAFETY: as above.
unsafe impl Sync for NativeFunction {}

impl fmt::Debug for NativeFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NativeFunction({:#x})", self.code)
    }
}

/// Data that libffi passes to [`enter`].
struct Bound<T> {
    callback: Callback<T>,
    data: T,
}

impl NativeFunction {
    /// Makes the function; `None` when there is no memory for executable code.
    pub(crate) fn new<T: Send + Sync + 'static>(
        arguments: &[Class],
        callback: Callback<T>,
        data: T,
    ) -> Option<Self> {
        let cif = Box::new(Interface::new(arguments)?.into_cif());
        let bound = Box::new(Bound { callback, data });
        let (closure, code) = low::try_closure_alloc()?;
        // SAFETY: `closure` was allocated just now; `cif` and `bound` are in boxes that are dropped
        // with the function, after the closure.
        let made = unsafe {
            low::prep_closure(closure, cif.as_raw_ptr(), enter::<T>, &raw const *bound, code)
        };
        if made.is_err() {
            // SAFETY: allocated above, never called.
            unsafe { low::closure_free(closure) };
            return None;
        }
        Some(Self { _cif: cif, _data: bound, closure, code: code.as_ptr() as usize })
    }

    /// Makes a C++ function that may throw; its first argument is the object.
    pub(crate) fn throwing<T: Send + Sync + 'static>(
        arguments: &[Class],
        callback: Throwing<T>,
        data: T,
    ) -> Option<Self> {
        let cif = Box::new(Interface::new(arguments)?.into_cif());
        let thrower = Box::new(Thrower { callback, data });
        let entry = Entry { call: throwing::<T>, data: (&raw const *thrower).cast() };
        let bound = Box::new((entry, thrower));
        let (closure, code) = low::try_closure_alloc()?;
        // SAFETY: as in `new`; the shim reads the entry at the beginning of the box.
        let made = unsafe {
            low::prep_closure(
                closure,
                cif.as_raw_ptr(),
                genom_host_remote_enter,
                &raw const bound.0,
                code,
            )
        };
        if made.is_err() {
            // SAFETY: allocated above, never called.
            unsafe { low::closure_free(closure) };
            return None;
        }
        Some(Self { _cif: cif, _data: bound, closure, code: code.as_ptr() as usize })
    }

    /// Its address, for C code to call.
    pub(crate) fn address(&self) -> usize {
        self.code
    }
}

impl Drop for NativeFunction {
    fn drop(&mut self) {
        // SAFETY: allocated in `new`. The component drops its functions after its threads have
        // ended, so none is running.
        unsafe { low::closure_free(self.closure) };
    }
}

unsafe extern "C" fn enter<T>(
    _: &low::ffi_cif,
    result: &mut *const c_void,
    arguments: *const *const c_void,
    bound: &Bound<T>,
) {
    let arguments = Arguments { at: arguments, _call: PhantomData };
    let run = || (bound.callback)(&bound.data, arguments);
    // Unwinding into C would abort the daemon; return a null event or datum instead.
    *result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_or_else(|_| {
        tracing::error!("a method of a port or remote panicked");
        std::ptr::null()
    });
}

/// Data for the shim (`struct remote`), which calls and throws the result.
#[repr(C)]
struct Entry {
    call: unsafe extern "C" fn(*const c_void, *const *const c_void) -> *const Raise,
    data: *const c_void,
}

// SAFETY: `data` points to a thrower, which is `Send` and `Sync` as its data is.
unsafe impl Send for Entry {}
// SAFETY: as above.
unsafe impl Sync for Entry {}

/// Data of a throwing function, which the shim passes.
struct Thrower<T> {
    callback: Throwing<T>,
    data: T,
}

unsafe extern "C" {
    fn genom_host_remote_enter(
        cif: &low::ffi_cif,
        result: &mut c_void,
        arguments: *const *const c_void,
        bound: &Entry,
    );
}

unsafe extern "C" fn throwing<T>(
    thrower: *const c_void,
    arguments: *const *const c_void,
) -> *const Raise {
    // SAFETY: the shim passes the pointer in the entry, which lives as long as the function.
    let thrower = unsafe { &*thrower.cast::<Thrower<T>>() };
    let arguments = Arguments { at: arguments, _call: PhantomData };
    let run = || (thrower.callback)(&thrower.data, arguments);
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_or_else(|_| {
        tracing::error!("a method of a remote panicked");
        std::ptr::null()
    })
}

/// The arguments of one call from C.
#[derive(Clone, Copy)]
pub(crate) struct Arguments<'call> {
    at: *const *const c_void,
    _call: PhantomData<&'call ()>,
}

impl<'call> Arguments<'call> {
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
