//! Memory of the C heap: strings and sequences are shared with C code, which releases them with
//! `free`.

use std::alloc::{Layout, handle_alloc_error};
use std::ffi::c_void;

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(pointer: *mut c_void);
}

/// Releases memory of [`zeroed`]. C code recognises such memory by comparing this address with
/// `free`.
pub(crate) const FREE: unsafe extern "C" fn(*mut c_void) = free;

/// Zeroed memory for `count` values of `T`; never null.
pub(crate) fn zeroed<T>(count: usize) -> *mut T {
    // SAFETY: calloc takes any sizes, and fails on a product that overflows.
    let pointer = unsafe { calloc(count.max(1), size_of::<T>().max(1)) }.cast::<T>();
    if pointer.is_null() {
        handle_alloc_error(Layout::array::<T>(count).unwrap_or(Layout::new::<T>()));
    }
    pointer
}

/// Releases memory of [`zeroed`] or of C's `malloc`.
///
/// # Safety
/// `pointer` is null or was allocated by this C library, and is not used afterwards.
pub(crate) unsafe fn release<T>(pointer: *mut T) {
    // SAFETY: the caller's promise.
    unsafe { free(pointer.cast()) }
}
