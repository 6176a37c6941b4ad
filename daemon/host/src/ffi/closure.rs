//! C functions with data of their own: the methods of ports and remotes, which do not get their
//! handle as an argument (genom3.md 5.7). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::any::Any;
use std::ffi::c_void;
use std::fmt;

use libffi::low;
use libffi::middle::Cif;

use super::arguments::{Arguments, Bound, Callback};
use super::slots::Taken;
use super::{Class, Interface};
use crate::cxx::Raise;

/// As [`Callback`], but returns an exception that the function throws, or null.
pub(crate) type Throwing<T> = fn(&T, Arguments<'_>) -> *const Raise;

/// A C function that calls a callback with its data.
pub(crate) struct NativeFunction {
    code: usize,
    /// What has to live as long.
    _kept: Box<dyn Any + Send + Sync>,
}

impl fmt::Debug for NativeFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NativeFunction({:#x})", self.code)
    }
}

impl NativeFunction {
    /// Makes the function, which calls `callback` with `data`; `None` when there is no memory for
    /// executable code. It may be dropped when no thread calls it any more.
    pub(crate) fn new<T: Send + Sync + 'static>(
        arguments: &[Class],
        callback: Callback<T>,
        data: T,
    ) -> Option<Self> {
        let mut bound = Bound::new(callback, data);
        if arguments == [Class::Address] {
            match Taken::new(bound) {
                Ok(taken) => {
                    return Some(Self { code: taken.address(), _kept: Box::new(taken) });
                }
                Err(back) => bound = back,
            }
        }
        let bound = Box::new(bound);
        Closure::new(arguments, |closure, cif, code| {
            // SAFETY: the closure and the code belong together and are new; the interface and
            // `bound` are in boxes that are dropped after the closure.
            unsafe { low::prep_closure(closure, cif, enter::<T>, &raw const *bound, code) }
        })
        .map(|closure| Self { code: closure.code, _kept: Box::new((closure, bound)) })
    }

    /// Makes a C++ function that may throw; its first argument is the object.
    pub(crate) fn throwing<T: Send + Sync + 'static>(
        arguments: &[Class],
        callback: Throwing<T>,
        data: T,
    ) -> Option<Self> {
        let thrower = Box::new(Thrower { callback, data });
        let entry = Entry { call: throwing::<T>, data: (&raw const *thrower).cast() };
        let entry = Box::new(entry);
        Closure::new(arguments, |closure, cif, code| {
            let shim = genom_host_remote_enter;
            // SAFETY: as in `new`, with the entry, which the shim reads.
            unsafe { low::prep_closure(closure, cif, shim, &raw const *entry, code) }
        })
        .map(|closure| Self { code: closure.code, _kept: Box::new((closure, entry, thrower)) })
    }

    /// Its address, for C code to call.
    pub(crate) fn address(&self) -> usize {
        self.code
    }
}

/// A closure of libffi.
struct Closure {
    closure: *mut low::ffi_closure,
    code: usize,
    // Libffi keeps its address.
    _cif: Box<Cif>,
}

// SAFETY: after construction it is only called.
unsafe impl Send for Closure {}
// SAFETY: as above.
unsafe impl Sync for Closure {}

impl Closure {
    /// Makes a closure of this interface; `prepare` tells libffi what it calls.
    fn new(
        arguments: &[Class],
        prepare: impl FnOnce(
            *mut low::ffi_closure,
            *mut low::ffi_cif,
            low::CodePtr,
        ) -> Result<(), low::Error>,
    ) -> Option<Self> {
        let cif = Box::new(Interface::new(arguments)?.into_cif());
        let (closure, code) = low::try_closure_alloc()?;
        let made = Self { closure, code: code.as_ptr() as usize, _cif: cif };
        prepare(closure, made._cif.as_raw_ptr(), code).ok().map(|()| made)
    }
}

impl Drop for Closure {
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
    // SAFETY: libffi passes the addresses of the arguments of the closure's interface.
    *result = bound.run(unsafe { Arguments::at(arguments) });
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
    // SAFETY: the shim passes on what libffi passed, as in `enter`.
    let arguments = unsafe { Arguments::at(arguments) };
    let run = || (thrower.callback)(&thrower.data, arguments);
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_or_else(|_| {
        tracing::error!("a method of a remote panicked");
        std::ptr::null()
    })
}
