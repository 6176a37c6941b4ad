//! Declarations of the C++ shim. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};

use genom_types::Record;

use super::layout::CxxType;

unsafe extern "C" {
    pub(super) fn genom_host_string_make(at: *mut u8);
    pub(super) fn genom_host_string_drop(at: *mut u8);
    pub(super) fn genom_host_string_set(at: *mut u8, text: *const u8, length: usize);
    pub(super) fn genom_host_string_get(at: *const u8, length: *mut usize) -> *const u8;
    pub(super) fn genom_host_flags_make(at: *mut u8);
    pub(super) fn genom_host_flags_drop(at: *mut u8);
    pub(super) fn genom_host_flags_set(at: *mut u8, from: *const u8, length: usize);
    pub(super) fn genom_host_flags_length(at: *const u8) -> usize;
    pub(super) fn genom_host_flags_get(at: *const u8, to: *mut u8);
    pub(super) fn genom_host_storage(bytes: usize) -> *mut u8;
    pub(super) fn genom_host_storage_free(at: *mut u8);
    fn genom_host_demangle(name: *const c_char) -> *mut c_char;
    fn genom_host_raised_what(object: *const c_void) -> *const c_char;
    fn genom_host_exception_type() -> *const c_void;
    pub(super) fn genom_host_port_make(
        at: *mut usize,
        out: c_int,
        multiple: c_int,
        methods: *const Methods,
        port: *const c_void,
    );
    fn free(at: *mut c_void);
}

/// An exception for the shim to throw (`struct raise`).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Raise {
    pub(super) vtable: usize,
    pub(super) ty: usize,
    pub(super) detail: *const u8,
    pub(super) size: usize,
    /// Constructs the detail from `detail`, with the type in the vtable.
    pub(super) construct: Option<unsafe extern "C" fn(*const Record, *const CxxType, *mut u8)>,
}

/// Implementations of a port's methods (`struct methods`).
#[repr(C)]
pub(super) struct Methods {
    pub(super) data:
        unsafe extern "C" fn(*const c_void, *const c_char, *mut *const Raise) -> *const c_void,
    pub(super) act: unsafe extern "C" fn(*const c_void, c_int, *const c_char) -> *const Raise,
}

/// Demangles a C++ name.
pub(super) fn demangled(name: &str) -> Option<String> {
    let name = CString::new(name).ok()?;
    // SAFETY: the name is a C string; the result is null or memory of malloc.
    unsafe {
        let text = genom_host_demangle(name.as_ptr());
        if text.is_null() {
            return None;
        }
        let owned = CStr::from_ptr(text).to_string_lossy().into_owned();
        free(text.cast());
        Some(owned)
    }
}

/// Address of `what()` for exceptions made by the host.
pub(super) fn what_function() -> usize {
    genom_host_raised_what as *const () as usize
}

/// `typeid(genom::exception)`.
pub(super) fn exception_type() -> usize {
    // SAFETY: no precondition.
    unsafe { genom_host_exception_type() as usize }
}
