//! Values at addresses that others own: IDS members, arguments of codels, buffers of ports.
//!
//! Everything here is `unsafe` for one reason: the caller vouches for the address.

use crate::data_type::DataType;
use crate::memory;

/// Makes the zeroed memory at `at` an empty value: sets `_maximum` of bounded sequences.
///
/// # Safety
/// `at` is zeroed memory of the type's size and alignment.
pub unsafe fn init_value(ty: &DataType, at: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { memory::init(ty.graph(), ty.ix(), at) }
}

/// Makes the value at `to` equal to that at `from`, deep; allocates nothing for fixed-size types.
///
/// # Safety
/// Both hold values of the type, do not overlap, and nobody changes them meanwhile.
pub unsafe fn copy_value(ty: &DataType, from: *const u8, to: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { memory::copy(ty.graph(), ty.ix(), from, to, 0) }
}

/// Releases what the value at `at` owns and makes it empty.
///
/// # Safety
/// `at` holds a value of the type that nobody uses meanwhile.
pub unsafe fn release_value(ty: &DataType, at: *mut u8) {
    // SAFETY: the caller's promise.
    unsafe { memory::release(ty.graph(), ty.ix(), at, 0) }
}
