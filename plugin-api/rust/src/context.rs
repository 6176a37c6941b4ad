//! The context of a codel, through which exceptions are thrown (genom3.md 5.4).

use std::ffi::{CStr, c_char, c_void};
use std::marker::PhantomData;
use std::mem::{offset_of, size_of};

/// The C struct behind a context.
#[derive(Debug)]
#[repr(C)]
pub struct ContextInterface {
    /// Records an exception with a copy of its detail. Returns the exception, or `::genom::fatal`
    /// on failure.
    pub raise: unsafe extern "C" fn(
        exception: *const c_char,
        detail: *const c_void,
        size: usize,
        context: *const ContextInterface,
    ) -> *const c_char,
    /// Returns the exception recorded last, and a pointer to its detail.
    pub raised: unsafe extern "C" fn(
        exception: *mut *const c_char,
        context: *const ContextInterface,
    ) -> *const c_void,
    /// Private data of the host.
    pub data: *mut c_void,
}

const _: () = assert!(
    size_of::<ContextInterface>() == 24
        && offset_of!(ContextInterface, raised) == 8
        && offset_of!(ContextInterface, data) == 16
);

/// The context that a codel is called with. It is valid in the thread of the call, until the codel
/// returns.
#[derive(Debug)]
pub struct Context {
    interface: *const ContextInterface,
    /// A context must be used in the thread of the call only.
    not_send: PhantomData<*mut ()>,
}

impl Context {
    /// The context that a codel received as its last argument.
    ///
    /// # Safety
    /// `interface` is the argument the host called the codel with, and the call has not ended.
    #[must_use]
    pub unsafe fn from_raw(interface: *const ContextInterface) -> Self {
        Self { interface, not_send: PhantomData }
    }

    /// The pointer to pass to methods of ports.
    pub(crate) fn as_raw(&self) -> *const ContextInterface {
        self.interface
    }

    /// Records exception `id` with a copy of `detail`. Returns the value that the codel is to
    /// return.
    pub(crate) fn raise<T: Copy>(&self, id: &'static CStr, detail: &T) -> *const c_char {
        let size = size_of::<T>();
        let pointer = if size == 0 { std::ptr::null() } else { std::ptr::from_ref(detail).cast() };
        // SAFETY: the interface is the host's for the time of the call (`from_raw`); `detail`
        // is `size` readable bytes, and `T: Copy` owns nothing that the copy would share.
        unsafe { ((*self.interface).raise)(id.as_ptr(), pointer, size, self.interface) }
    }

    /// Full name of the exception recorded last in this context, by a codel or by a port.
    #[must_use]
    pub fn raised(&self) -> Option<&CStr> {
        let mut exception = std::ptr::null();
        // SAFETY: the interface is the host's for the time of the call (`from_raw`).
        unsafe { ((*self.interface).raised)(&mut exception, self.interface) };
        if exception.is_null() {
            return None;
        }
        // SAFETY: events are NUL-terminated constants of the host or of a library (genom3.md 5.3).
        Some(unsafe { CStr::from_ptr(exception) })
    }
}
