//! Ports as C++ codels see them: objects with virtual functions that throw (genom3.md 6). One of
//! the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Arc;

use super::exceptions::Exceptions;
use super::shim::{self, Methods, Raise};
use crate::detail::Detail;

/// Operations of a port, for any language: `Err` is an exception's name and its detail in C layout.
pub(crate) trait CxxPort: Send + Sync {
    /// Address of the datum.
    fn data(&self, id: Option<&[u8]>) -> Result<usize, (&'static str, Vec<u8>)>;
    /// Reads, writes, opens or closes.
    fn act(&self, action: Action, id: Option<&[u8]>) -> Result<(), (&'static str, Vec<u8>)>;
}

/// Operations of methods; the numbers are those of the shim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Read,
    Write,
    Open,
    Close,
}

/// The object whose reference codels get.
pub(crate) struct Handle {
    /// Constructed by the shim; needs no destruction.
    object: Box<[usize; 3]>,
    _bound: Box<Bound>,
}

/// State of its methods.
struct Bound {
    port: Box<dyn CxxPort>,
    exceptions: Arc<Exceptions>,
}

static METHODS: Methods = Methods { data, act };

impl Handle {
    /// The object for a port.
    pub(crate) fn new(
        port: Box<dyn CxxPort>,
        (out, multiple): (bool, bool),
        exceptions: &Arc<Exceptions>,
    ) -> Self {
        let bound = Box::new(Bound { port, exceptions: Arc::clone(exceptions) });
        let mut object = Box::new([0; 3]);
        // SAFETY: the box holds three words, as the shim requires; its content does not move.
        unsafe {
            shim::genom_host_port_make(
                object.as_mut_ptr(),
                out.into(),
                multiple.into(),
                &raw const METHODS,
                (&raw const *bound).cast(),
            );
        }
        Self { object, _bound: bound }
    }

    /// The address that codels get as a reference.
    pub(crate) fn address(&self) -> *const c_void {
        self.object.as_ptr().cast()
    }
}

/// The id of a multiple port's element.
///
/// # Safety
/// `id` is NULL or a C string.
unsafe fn name<'a>(id: *const c_char) -> Option<&'a [u8]> {
    // SAFETY: the caller's promise.
    (!id.is_null()).then(|| unsafe { CStr::from_ptr(id) }.to_bytes())
}

unsafe extern "C" fn data(
    bound: *const c_void,
    id: *const c_char,
    failed: *mut *const Raise,
) -> *const c_void {
    // SAFETY: the shim passes what the handle was constructed with, which lives as long as the
    // handle.
    let (bound, id) = unsafe { (&*bound.cast::<Bound>(), name(id)) };
    match bound.port.data(id) {
        Ok(at) => at as *const c_void,
        Err((exception, detail)) => {
            // SAFETY: the shim provides memory for it.
            unsafe { failed.write(bound.exceptions.raise(exception, Detail::Bytes(detail))) };
            std::ptr::null()
        }
    }
}

unsafe extern "C" fn act(bound: *const c_void, action: c_int, id: *const c_char) -> *const Raise {
    // SAFETY: as above.
    let (bound, id) = unsafe { (&*bound.cast::<Bound>(), name(id)) };
    let action = match action {
        0 => Action::Read,
        1 => Action::Write,
        2 => Action::Open,
        _ => Action::Close,
    };
    match bound.port.act(action, id) {
        Ok(()) => std::ptr::null(),
        Err((exception, detail)) => bound.exceptions.raise(exception, Detail::Bytes(detail)),
    }
}
