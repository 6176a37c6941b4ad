//! Data types with the memory layout of their C mapping (genom3.md 5.2).
//!
//! Values of these types are valid if all their bytes are zero, and for any bytes that C code may
//! write. What Rust does not allow, such as a `bool` of value 2, is checked when it is read.

mod enumeration;
mod native;
mod optional;
mod scalar;
mod sequence;
mod string;

use std::ffi::CStr;

use crate::abi::{Kind, List, TypeDescriptor};

pub use enumeration::{Enum, Enumeration};
pub use native::{Native, NativeType};
pub use optional::Optional;
pub use scalar::{Bool, Scalar};
pub use sequence::{BoundedSequence, Sequence};
pub use string::{BoundedString, Text};

/// A type that may lie in the IDS, in a port or in a parameter; `#[derive(Data)]` implements it
/// for `#[repr(C)]` structs and for enums.
///
/// # Safety
/// `Self` has the layout of the C mapping of the IDL type that [`Data::TYPE`] describes, and is
/// valid for every value that C code may put there, all bytes zero included.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no IDL type",
    note = "derive `genom::Data`; for texts, booleans and enums within data use `genom::Text`, \
            `genom::BoundedString`, `genom::Bool` and `genom::Enum`"
)]
pub unsafe trait Data: Sized + 'static {
    /// Descriptor of the type for the host: the address of a constant.
    const TYPE: *const TypeDescriptor;
}

/// Data that is passed to a codel by address if the codel only reads it: structs, arrays,
/// sequences, optionals and bounded strings, but not scalars (genom3.md 5.5).
pub trait Aggregate: Data {}

/// The descriptor of `T` as a type without name and members.
const fn plain<T>(kind: Kind, bound: usize, element: *const TypeDescriptor) -> TypeDescriptor {
    TypeDescriptor {
        kind,
        reserved: 0,
        name: std::ptr::null(),
        size: size_of::<T>(),
        align: align_of::<T>(),
        bound,
        element,
        members: List::EMPTY,
    }
}

/// The descriptor of `T` as a named type without members.
const fn named<T>(kind: Kind, name: &'static CStr) -> TypeDescriptor {
    let mut descriptor = plain::<T>(kind, 0, std::ptr::null());
    descriptor.name = name.as_ptr();
    descriptor
}

// SAFETY: a C array is its elements in a row, as a Rust array is.
unsafe impl<T: Data, const N: usize> Data for [T; N] {
    const TYPE: *const TypeDescriptor = &plain::<Self>(Kind::ARRAY, N, T::TYPE);
}

impl<T: Data, const N: usize> Aggregate for [T; N] {}
