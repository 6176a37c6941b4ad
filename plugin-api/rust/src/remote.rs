//! Remotes: services of other components (genom3.md 5.8). [`remote!`](crate::remote) generates
//! their types; this module holds what these have in common.

use std::ffi::{c_char, c_void};
use std::fmt;

use crate::context::ContextInterface;
use crate::port::checked;
use crate::{Context, Thrown};

/// Handle of a remote, provided by the host: a struct with one method, passed by address.
#[repr(transparent)]
pub struct Handle(*const c_void);

impl Handle {
    /// The method `call` of the handle.
    ///
    /// # Safety
    /// The handle was passed to the running codel, and `F` is the type of its method.
    #[must_use]
    pub unsafe fn method<F: Copy>(&self) -> F {
        const { assert!(size_of::<F>() == size_of::<*const c_void>(), "a function pointer") };
        // SAFETY: the caller's promise; the host keeps handles while codels run.
        unsafe { *self.0.cast::<F>() }
    }
}

impl fmt::Debug for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Remote")
    }
}

/// Calls the method of a remote with the C context, and converts the result.
///
/// # Errors
/// The exception that the method returned.
pub fn call(
    context: &Context,
    method: impl FnOnce(*const ContextInterface) -> *const c_char,
) -> Result<(), Thrown> {
    checked(method(context.as_raw()))
}
