//! How arguments of codels are passed from C to Rust (genom3.md 5.5).
//!
//! [`codel`](crate::codel) and [`remote!`](crate::remote) select the trait by how the type of the
//! parameter is written: `T`, `&T` or `&mut T`. Only their expansions call the functions that turn
//! pointers into references.

use std::ffi::{CStr, c_char};

use crate::abi::{Passing, TypeDescriptor};
use crate::data::{Aggregate, Data, Enum, Enumeration, Native, NativeType};

/// A parameter written `T`: an `in` scalar.
#[diagnostic::on_unimplemented(
    message = "a codel takes no `{Self}` by value",
    note = "numbers, `bool` and `Enum<E>` are taken by value, other data as `&T` when the codel \
            only reads it, and all data as `&mut T` when it writes it"
)]
pub trait ByValue: Sized {
    /// Its type in C.
    type Abi;
    /// Descriptor of its IDL type.
    const TYPE: *const TypeDescriptor;

    /// Converts the argument of a codel from C.
    fn from_abi(abi: Self::Abi) -> Self;

    /// Converts the argument of a remote to C.
    fn into_abi(self) -> Self::Abi;
}

macro_rules! by_value {
    ($($ty:ty),*) => {$(
        impl ByValue for $ty {
            type Abi = Self;
            const TYPE: *const TypeDescriptor = <Self as Data>::TYPE;

            fn from_abi(abi: Self) -> Self {
                abi
            }

            fn into_abi(self) -> Self {
                self
            }
        }
    )*};
}

by_value!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

impl ByValue for bool {
    type Abi = u8;
    const TYPE: *const TypeDescriptor = <crate::Bool as Data>::TYPE;

    fn from_abi(abi: u8) -> Self {
        abi != 0
    }

    fn into_abi(self) -> u8 {
        self.into()
    }
}

impl<E: Enumeration> ByValue for Enum<E> {
    type Abi = Self;
    const TYPE: *const TypeDescriptor = <Self as Data>::TYPE;

    fn from_abi(abi: Self) -> Self {
        abi
    }

    fn into_abi(self) -> Self {
        self
    }
}

/// A parameter written `&T`: `in` data that is not a scalar.
#[diagnostic::on_unimplemented(
    message = "a codel takes no `&{Self}`",
    note = "an `in` number is taken by value, an `in string` as `&CStr`, ports and \
            remotes as `&mut`"
)]
pub trait ByRef {
    /// Its type in C.
    type Abi;
    /// The value that the C function stores while the codel runs.
    type Held;
    /// How it is passed.
    const PASSING: Passing;
    /// Descriptor of its IDL type.
    const TYPE: *const TypeDescriptor;

    /// Stores the C value.
    ///
    /// # Safety
    /// `abi` is the argument of the running codel.
    unsafe fn hold(abi: Self::Abi) -> Self::Held;

    /// Converts the stored value to the argument of the Rust function.
    fn lend(held: &Self::Held) -> &Self;

    /// Converts the argument of a remote to C; the result is valid as long as `self`.
    fn to_abi(&self) -> Self::Abi;
}

impl<T: Aggregate> ByRef for T {
    type Abi = *const T;
    type Held = &'static T;
    const PASSING: Passing = Passing::SHARED;
    const TYPE: *const TypeDescriptor = <T as Data>::TYPE;

    unsafe fn hold(abi: *const T) -> &'static T {
        // SAFETY: the host passes the address of a datum of this type (it compared the layouts
        // at load), which no one changes while the codel runs (genom3.md 4.5). `lend` gives it
        // the lifetime of the call.
        unsafe { &*abi }
    }

    fn lend<'a>(held: &'a &'static T) -> &'a T {
        held
    }

    fn to_abi(&self) -> *const T {
        self
    }
}

impl ByRef for CStr {
    type Abi = *const c_char;
    type Held = &'static CStr;
    const PASSING: Passing = Passing::VALUE;
    const TYPE: *const TypeDescriptor = <crate::Text as Data>::TYPE;

    unsafe fn hold(abi: *const c_char) -> &'static CStr {
        if abi.is_null() {
            return c"";
        }
        // SAFETY: a string of the C mapping is NUL-terminated, and stays while the codel runs.
        unsafe { CStr::from_ptr(abi) }
    }

    fn lend<'a>(held: &'a &'static CStr) -> &'a CStr {
        held
    }

    fn to_abi(&self) -> *const c_char {
        self.as_ptr()
    }
}

impl<T: NativeType> ByRef for Native<T> {
    type Abi = *const T;
    type Held = Native<T>;
    const PASSING: Passing = Passing::VALUE;
    const TYPE: *const TypeDescriptor = <Self as Data>::TYPE;

    unsafe fn hold(abi: *const T) -> Native<T> {
        Native::view(abi)
    }

    fn lend(held: &Native<T>) -> &Native<T> {
        held
    }

    fn to_abi(&self) -> *const T {
        self.as_ptr()
    }
}

/// A parameter written `&mut T`: `out` or `inout` data, a port or a remote.
#[diagnostic::on_unimplemented(message = "a codel takes no `&mut {Self}`")]
pub trait ByMut {
    /// Its type in C.
    type Abi;
    /// The value that the C function stores while the codel runs.
    type Held;
    /// How it is passed.
    const PASSING: Passing;
    /// Descriptor of its type; for a port, of the type of its data.
    const TYPE: *const TypeDescriptor;

    /// Stores the C value.
    ///
    /// # Safety
    /// `abi` is the argument of the running codel.
    unsafe fn hold(abi: Self::Abi) -> Self::Held;

    /// Converts the stored value to the argument of the Rust function.
    fn lend(held: &mut Self::Held) -> &mut Self;
}

impl<T: Data> ByMut for T {
    type Abi = *mut T;
    type Held = &'static mut T;
    const PASSING: Passing = Passing::EXCLUSIVE;
    const TYPE: *const TypeDescriptor = <T as Data>::TYPE;

    unsafe fn hold(abi: *mut T) -> &'static mut T {
        // SAFETY: the host passes the address of a datum of this type (it compared the layouts
        // at load), which no other codel sees meanwhile (genom3.md 4.5). `lend` gives it the
        // lifetime of the call.
        unsafe { &mut *abi }
    }

    fn lend<'a>(held: &'a mut &'static mut T) -> &'a mut T {
        held
    }
}
