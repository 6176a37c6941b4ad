//! The table that a component library exports, and its C layout.
//!
//! A host reads the table and compares it with the `.gen` file before it calls anything. The table
//! is constant data of the library: valid as long as the library is loaded, and readable from any
//! thread. C and C++ libraries have no table; the host checks them by their debug information.

use std::ffi::{CStr, c_char, c_void};
use std::mem::{offset_of, size_of};

/// Major version of the table. A host refuses a library with another one.
pub const ABI_MAJOR: u16 = 1;
/// Minor version. Higher ones have more fields at the end of [`Component`].
pub const ABI_MINOR: u16 = 0;
/// Symbol of the static [`Component`].
pub const COMPONENT_SYMBOL: &CStr = c"genom_component";
/// Symbol of the `.gen` text, NUL-terminated; C and C++ libraries may have it too.
pub const DESCRIPTION_SYMBOL: &CStr = c"genom_description";

/// What a component library exports as the static `genom_component`.
///
/// The first three fields never move: a host of any version may read them.
#[derive(Debug)]
#[repr(C)]
pub struct Component {
    /// [`ABI_MAJOR`] of the SDK the library was built with.
    pub abi_major: u16,
    /// [`ABI_MINOR`] of the SDK the library was built with.
    pub abi_minor: u16,
    /// `size_of::<Component>()` as the library saw it: a host reads no further.
    pub size: u32,
    /// The `.gen` text the library was built from, NUL-terminated.
    pub description: *const c_char,
    /// Every codel of the library.
    pub codels: List<CodelDescriptor>,
    /// Exceptions that the codels throw, described as structs; those without detail have no
    /// members.
    pub exceptions: List<*const TypeDescriptor>,
}

/// A codel: a C function of the library, and its arguments.
#[derive(Debug)]
#[repr(C)]
pub struct CodelDescriptor {
    /// Name of the function, NUL-terminated; it is also a symbol of the library.
    pub name: *const c_char,
    /// Address of the function.
    pub function: *const c_void,
    /// Arguments in order, without the context that ends every codel's arguments.
    pub arguments: List<ArgumentDescriptor>,
}

/// An argument of a codel.
#[derive(Debug)]
#[repr(C)]
pub struct ArgumentDescriptor {
    /// Its name in the Rust function, NUL-terminated; the `.gen` file may use another.
    pub name: *const c_char,
    /// How it is passed.
    pub passing: Passing,
    /// Always 0.
    pub reserved: u32,
    /// Its type; for a port, the type of its data.
    pub ty: *const TypeDescriptor,
}

/// How an argument is passed (genom3.md 5.5). A host refuses unknown numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Passing(pub u32);

impl Passing {
    /// `in`: the scalar itself; for an unbounded string or a native, the pointer.
    pub const VALUE: Self = Self(0);
    /// `in`: address of data that the codel only reads.
    pub const SHARED: Self = Self(1);
    /// `out` or `inout`: address of data that the codel may change.
    pub const EXCLUSIVE: Self = Self(2);
    /// `port in`.
    pub const IN_PORT: Self = Self(3);
    /// `port out`.
    pub const OUT_PORT: Self = Self(4);
    /// `port multiple in`.
    pub const MULTIPLE_IN_PORT: Self = Self(5);
    /// `port multiple out`.
    pub const MULTIPLE_OUT_PORT: Self = Self(6);
    /// A remote; its type is of kind [`Kind::REMOTE`].
    pub const REMOTE: Self = Self(7);
}

/// A type as compiled into the library: its kind, and where its members are.
///
/// Typedefs are left out: they make no difference in memory.
#[derive(Debug)]
#[repr(C)]
pub struct TypeDescriptor {
    /// Its kind.
    pub kind: Kind,
    /// Always 0.
    pub reserved: u32,
    /// Full name, such as `::demo::state`, of an enum, struct, exception or native; otherwise null.
    pub name: *const c_char,
    /// Size in bytes.
    pub size: usize,
    /// Alignment in bytes.
    pub align: usize,
    /// Length of an array, or bound of a string (including the NUL) or sequence; 0 if unbounded.
    pub bound: usize,
    /// Type of the elements of an array, sequence or optional; otherwise null.
    pub element: *const TypeDescriptor,
    /// Members of a struct or exception; enumerators of an enum, whose values are their indices;
    /// parameters of a remote.
    pub members: List<MemberDescriptor>,
}

/// A member of a struct or exception, an enumerator, or a parameter of a remote.
#[derive(Debug)]
#[repr(C)]
pub struct MemberDescriptor {
    /// Its name, NUL-terminated, without the prefix `r#` of Rust.
    pub name: *const c_char,
    /// Offset in the struct, in bytes; 0 for an enumerator; the number of its [`Passing`] for a
    /// parameter.
    pub offset: usize,
    /// Its type; null for an enumerator.
    pub ty: *const TypeDescriptor,
}

/// The kind of a type (genom3.md 5.2). A host refuses unknown numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Kind(pub u32);

#[allow(missing_docs, reason = "most are the IDL type they are named after")]
impl Kind {
    pub const BOOLEAN: Self = Self(0);
    pub const CHAR: Self = Self(1);
    pub const OCTET: Self = Self(2);
    pub const SHORT: Self = Self(3);
    pub const UNSIGNED_SHORT: Self = Self(4);
    pub const LONG: Self = Self(5);
    pub const UNSIGNED_LONG: Self = Self(6);
    pub const LONG_LONG: Self = Self(7);
    pub const UNSIGNED_LONG_LONG: Self = Self(8);
    pub const FLOAT: Self = Self(9);
    pub const DOUBLE: Self = Self(10);
    pub const STRING: Self = Self(11);
    pub const ARRAY: Self = Self(12);
    pub const SEQUENCE: Self = Self(13);
    pub const OPTIONAL: Self = Self(14);
    pub const ENUM: Self = Self(15);
    pub const STRUCT: Self = Self(16);
    pub const UNION: Self = Self(17);
    pub const EXCEPTION: Self = Self(18);
    pub const NATIVE: Self = Self(19);
    /// A remote, which has no data: its members are the parameters, and the offset of each is the
    /// number of its [`Passing`].
    pub const REMOTE: Self = Self(20);
}

/// A constant array with its length.
#[derive(Debug)]
#[repr(C)]
pub struct List<T: 'static> {
    /// The first element; not to be read if `count` is 0.
    pub first: *const T,
    /// Number of elements.
    pub count: usize,
}

impl<T> List<T> {
    /// The empty list.
    pub const EMPTY: Self = Self::new(&[]);

    /// The list of the elements of `slice`.
    #[must_use]
    pub const fn new(slice: &'static [T]) -> Self {
        Self { first: slice.as_ptr(), count: slice.len() }
    }

    /// Elements of the list, `count` of them.
    ///
    /// # Safety
    /// The list is part of a table of a library that stays loaded for `'a`.
    #[must_use]
    pub unsafe fn as_slice<'a>(&self) -> &'a [T] {
        if self.count == 0 || self.first.is_null() {
            return &[];
        }
        // SAFETY: the library built the list from a slice (`new`), and is loaded for `'a`.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

// SAFETY: the table is constant data; its pointers lead to constant data of the same library.
unsafe impl Sync for Component {}
// SAFETY: as above.
unsafe impl Sync for CodelDescriptor {}
// SAFETY: as above.
unsafe impl Sync for ArgumentDescriptor {}
// SAFETY: as above.
unsafe impl Sync for TypeDescriptor {}
// SAFETY: as above.
unsafe impl Sync for MemberDescriptor {}

const _: () = {
    assert!(size_of::<usize>() == 8, "the table is laid out for 64-bit platforms");
    assert!(size_of::<Component>() == 48 && offset_of!(Component, size) == 4);
    assert!(offset_of!(Component, description) == 8 && offset_of!(Component, codels) == 16);
    assert!(offset_of!(Component, exceptions) == 32);
    assert!(size_of::<CodelDescriptor>() == 32 && offset_of!(CodelDescriptor, arguments) == 16);
    assert!(size_of::<ArgumentDescriptor>() == 24 && offset_of!(ArgumentDescriptor, ty) == 16);
    assert!(size_of::<TypeDescriptor>() == 64 && offset_of!(TypeDescriptor, name) == 8);
    assert!(offset_of!(TypeDescriptor, bound) == 32 && offset_of!(TypeDescriptor, members) == 48);
    assert!(size_of::<MemberDescriptor>() == 24 && offset_of!(MemberDescriptor, ty) == 16);
};
