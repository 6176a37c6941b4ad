//! The C library's functions, which those of this folder precede.

use std::ffi::{CStr, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};

/// A function of the C library, which is looked up once.
pub(super) struct Next {
    name: &'static CStr,
    found: AtomicPtr<c_void>,
}

impl Next {
    pub(super) const fn new(name: &'static CStr) -> Self {
        Self { name, found: AtomicPtr::new(ptr::null_mut()) }
    }

    /// Null if there is none: the program is linked statically.
    pub(super) fn get(&self) -> *mut c_void {
        let mut next = self.found.load(Ordering::Relaxed);
        if next.is_null() {
            // SAFETY: looks up a name after the program's own definition.
            next = unsafe { libc::dlsym(libc::RTLD_NEXT, self.name.as_ptr()) };
            self.found.store(next, Ordering::Relaxed);
        }
        next
    }
}
