//! Operations on values in memory that others own: IDS members, arguments of codels, port buffers.
//!
//! Every function is `unsafe` for the same reason: the caller guarantees what lies at the address.

use serde_json::Value;

use crate::cdr::{self, CdrError};
use crate::data_type::DataType;
use crate::graph::Shape;
use crate::json::{self, JsonError};
use crate::memory::{self, View};
use crate::record::Record;

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

/// The value at `at` as JSON.
///
/// # Safety
/// `at` holds a value of the type that nobody changes meanwhile.
#[must_use]
pub unsafe fn json_of(ty: &DataType, at: *const u8) -> Value {
    // SAFETY: the caller's promise.
    json::write(unsafe { View::new(ty.graph(), ty.ix(), at) })
}

/// Merges `json` into the value at `at`, as [`Record::merge_json`] does: on error nothing changes.
///
/// # Errors
/// A member, type, range or bound is wrong; the error gives its path and what is accepted.
///
/// # Safety
/// `at` holds a value of the type that nobody uses meanwhile.
pub unsafe fn merge_json_at(ty: &DataType, at: *mut u8, json: &Value) -> Result<(), JsonError> {
    let mut new = Record::new(ty);
    // SAFETY: the caller's promise; the record is elsewhere.
    unsafe {
        copy_value(ty, at, new.as_mut_ptr());
        new.merge_json(json)?;
        // The swap also exchanges owned memory; the record then drops the old value.
        std::ptr::swap_nonoverlapping(at, new.as_mut_ptr(), ty.size());
    }
    Ok(())
}

/// Appends the value at `at` as a CDR payload, as [`Record::encode_cdr`].
///
/// # Errors
/// An enum is out of range, a string is no UTF-8, or a native is inside.
///
/// # Safety
/// `at` holds a value of the type that nobody changes meanwhile.
pub unsafe fn encode_cdr_of(
    ty: &DataType,
    at: *const u8,
    out: &mut Vec<u8>,
) -> Result<(), CdrError> {
    // SAFETY: the caller's promise.
    unsafe { cdr::encode(ty.graph(), ty.ix(), at, out.len(), out) }
}

/// The bytes of the `string` at `at`, its NUL excluded; none for a null pointer.
///
/// # Safety
/// `at` holds an unbounded string that nobody changes while the slice is used.
#[must_use]
pub unsafe fn text_at<'a>(at: *const u8) -> &'a [u8] {
    // SAFETY: the caller's promise.
    unsafe { memory::text(at, None) }
}

/// Makes the `string` at `at` a copy of `bytes`, reusing its memory if it is large enough.
///
/// # Safety
/// `at` holds an unbounded string that nobody uses meanwhile; `bytes` lie elsewhere.
pub unsafe fn set_text_at(at: *mut u8, bytes: &[u8]) {
    // SAFETY: the caller's promise.
    unsafe { memory::set_text(at, None, bytes) }
}

/// The readable elements of the sequence at `at`: address of the first, and their number, which is
/// 0 when `ty` is no sequence.
///
/// # Safety
/// `at` holds a value of the type that nobody changes meanwhile.
#[must_use]
pub unsafe fn elements_at(ty: &DataType, at: *const u8) -> (*const u8, usize) {
    let Shape::Sequence { element, bound } = ty.node().shape else {
        return (std::ptr::null(), 0);
    };
    // SAFETY: the caller's promise.
    let (buffer, length) = unsafe { memory::elements(ty.graph(), element, bound, at) };
    (buffer, length)
}

/// Resizes the sequence at `at` to `length` elements, new ones empty; returns the address of the
/// first. `None` beyond the bound, without memory, or when `ty` is no sequence.
///
/// # Safety
/// `at` holds a value of the type that nobody uses meanwhile.
#[must_use]
pub unsafe fn resize_at(ty: &DataType, at: *mut u8, length: usize) -> Option<*mut u8> {
    let Shape::Sequence { element, bound } = ty.node().shape else { return None };
    // SAFETY: the caller's promise.
    unsafe { memory::resize(ty.graph(), (element, bound), at, length, 0) }
}
