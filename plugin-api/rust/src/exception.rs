//! Exceptions: how codels report errors.

use std::ffi::{CStr, c_char};
use std::fmt;

use crate::Context;
use crate::abi::{Kind, List, MemberDescriptor, TypeDescriptor};
use crate::data::{BoundedString, Data};

/// An exception of the `.gen` file; `#[derive(Exception)]` implements it.
///
/// The detail is copied as it is, so it owns nothing: texts in it are [`BoundedString`]s.
///
/// ```
/// use genom::{BoundedString, Context, Exception, Thrown};
///
/// #[derive(Clone, Copy, Exception)]
/// #[genom(name = "::demo::OUT_OF_RANGE")]
/// #[repr(C)]
/// struct OutOfRange {
///     limit: f64,
///     what: BoundedString<16>,
/// }
///
/// #[genom::codel]
/// fn demo_validate(goal: f64, context: &Context) -> Result<(), Thrown> {
///     if goal > 1.0 {
///         let what = BoundedString::new("goal");
///         return Err(OutOfRange { limit: 1.0, what }.raise(context));
///     }
///     Ok(())
/// }
/// assert_eq!(OutOfRange::ID, c"::demo::OUT_OF_RANGE");
/// ```
pub trait Exception: Copy {
    /// Full name, such as `::demo::OUT_OF_RANGE`.
    const ID: &'static CStr;
    /// Descriptor of its detail.
    const TYPE: *const TypeDescriptor;

    /// Records the exception, to be returned by the codel: `return Err(OutOfRange { ..
    /// }.raise(cx))`.
    fn raise(self, context: &Context) -> Thrown {
        Thrown(context.raise(Self::ID, &self))
    }
}

/// An exception recorded in the context; the codel returns it as its error.
#[must_use = "a recorded exception has no effect unless the codel returns it"]
#[derive(Clone, Copy)]
pub struct Thrown(pub(crate) *const c_char);

impl Thrown {
    /// Full name of the exception.
    #[must_use]
    pub fn name(&self) -> &CStr {
        // SAFETY: events are NUL-terminated constants of the host or of a library
        // (genom3.md 5.3), and both outlive the codel's call.
        unsafe { CStr::from_ptr(self.0) }
    }
}

impl fmt::Debug for Thrown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name().to_string_lossy())
    }
}

/// `::genom::syserr`: a system call failed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Syserr {
    /// `errno`.
    pub code: i32,
}

impl Exception for Syserr {
    const ID: &'static CStr = c"::genom::syserr";
    const TYPE: *const TypeDescriptor = &described::<Self>(
        const { &[MemberDescriptor { name: c"code".as_ptr(), offset: 0, ty: i32::TYPE }] },
    );
}

/// `::genom::unkex`: an error that the `.gen` file does not declare, with a message.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Unkex {
    /// The message.
    pub what: BoundedString<128>,
}

impl Unkex {
    /// The exception with this message, truncated to 127 bytes.
    #[must_use]
    pub fn new(what: &str) -> Self {
        Self { what: BoundedString::new(what) }
    }
}

impl Exception for Unkex {
    const ID: &'static CStr = c"::genom::unkex";
    const TYPE: *const TypeDescriptor = &described::<Self>(
        const {
            let ty = BoundedString::<128>::TYPE;
            &[MemberDescriptor { name: c"what".as_ptr(), offset: 0, ty }]
        },
    );
}

/// The descriptor of an exception with these members.
const fn described<E: Exception>(members: &'static [MemberDescriptor]) -> TypeDescriptor {
    TypeDescriptor {
        kind: Kind::EXCEPTION,
        reserved: 0,
        name: E::ID.as_ptr(),
        size: size_of::<E>(),
        align: align_of::<E>(),
        bound: 0,
        element: std::ptr::null(),
        members: List::new(members),
    }
}
