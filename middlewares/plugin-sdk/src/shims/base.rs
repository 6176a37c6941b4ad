//! What all functions of the table do: no panic crosses, and handles are boxes.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use genom_middleware::Middleware;
use genom_plugin_abi::table::{Opaque, level};
use genom_plugin_abi::{Code, ErrorText, Failure};

use crate::given::Functions;

/// An open backend.
pub(super) struct Opened {
    pub(super) middleware: Arc<dyn Middleware>,
    pub(super) host: Functions,
}

fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Runs the work of a function that can fail; a panic is a failure.
///
/// # Safety
/// `error` is null, or an error that the host lent.
pub(super) unsafe fn guarded(
    error: *mut ErrorText,
    work: impl FnOnce() -> Result<(), Failure>,
) -> Code {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let why = format!("the plugin panicked: {}", said(&*panic));
        Err(Failure::new(Code::FAILED, why))
    });
    match done {
        Ok(()) => Code::OK,
        Err(failure) => {
            // SAFETY: as for this function.
            unsafe { ErrorText::write(error, &failure) };
            failure.code
        }
    }
}

/// Runs the work of a function that has no way to tell of a failure but the log.
pub(super) fn logged<T: Default>(host: Option<Functions>, work: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        if let Some(host) = host {
            host.log(level::ERROR, &format!("the plugin panicked: {}", said(&*panic)));
        }
        T::default()
    })
}

/// Gives a value to the host as a handle.
///
/// # Safety
/// `out` is writable.
pub(super) unsafe fn give<T>(out: *mut Opaque, value: T) {
    // SAFETY: as for this function.
    unsafe { out.write(Box::into_raw(Box::new(value)).cast()) };
}

/// What a handle stands for.
///
/// # Safety
/// [`give`] gave it as a `T`, and it is not closed while the result is used.
pub(super) unsafe fn at<'a, T>(handle: Opaque) -> &'a T {
    // SAFETY: as for this function.
    unsafe { &*handle.cast::<T>() }
}

/// Takes back a handle.
///
/// # Safety
/// [`give`] gave it as a `T`, and nobody uses it any more.
pub(super) unsafe fn take<T>(handle: Opaque) -> Box<T> {
    // SAFETY: as for this function.
    unsafe { Box::from_raw(handle.cast::<T>()) }
}
