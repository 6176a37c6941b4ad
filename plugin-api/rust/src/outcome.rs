//! Return types of codels, and the conversion of panics to exceptions.

use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::{Context, Event, Exception, Thrown, Unkex};

/// Return type of a codel: [`Event`], `()` for functions and validation codels, or a `Result` of
/// these with error [`Thrown`].
pub trait Outcome {
    /// The C value: a full name, or null for success without an event.
    fn into_raw(self) -> *const c_char;
}

impl Outcome for Event {
    fn into_raw(self) -> *const c_char {
        self.name().as_ptr()
    }
}

impl Outcome for () {
    fn into_raw(self) -> *const c_char {
        std::ptr::null()
    }
}

impl Outcome for Thrown {
    fn into_raw(self) -> *const c_char {
        self.0
    }
}

impl<T: Outcome> Outcome for Result<T, Thrown> {
    fn into_raw(self) -> *const c_char {
        match self {
            Ok(outcome) => outcome.into_raw(),
            Err(thrown) => thrown.into_raw(),
        }
    }
}

/// Runs a codel, and converts a panic to `::genom::unkex` with the panic's message.
pub fn guard<R: Outcome>(context: &Context, codel: impl FnOnce() -> R) -> *const c_char {
    // Data of the codel may be partly modified, as after an exception of a codel in C.
    match catch_unwind(AssertUnwindSafe(codel)) {
        Ok(outcome) => outcome.into_raw(),
        Err(panic) => {
            let what = match (panic.downcast_ref::<&str>(), panic.downcast_ref::<String>()) {
                (Some(text), _) => text,
                (_, Some(text)) => text.as_str(),
                _ => "the codel panicked",
            };
            let raw = Unkex::new(what).raise(context).into_raw();
            // The payload's destructor may panic, too; the payload of that panic is leaked.
            if let Err(again) = catch_unwind(AssertUnwindSafe(move || drop(panic))) {
                std::mem::forget(again);
            }
            raw
        }
    }
}
