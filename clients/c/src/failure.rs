//! Why a function failed, until the next one of the same thread does.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// A sentence.
pub(crate) struct Failure(String);

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

impl Failure {
    fn new(what: impl Display) -> Self {
        Self(what.to_string())
    }

    pub(crate) fn null() -> Self {
        Self::new("a pointer is NULL: look at the result of the function that returned it")
    }

    pub(crate) fn no_text() -> Self {
        Self::new("a text is not UTF-8, or has a byte 0")
    }

    pub(crate) fn of_out_port(address: &str) -> Self {
        Self::new(format_args!("{address} is an out port, which codels write"))
    }

    pub(crate) fn of_size(address: &str, is: usize, asked: usize) -> Self {
        Self::new(format_args!(
            "{address} has values of {is} bytes, and the type of this program has {asked}: compile \
             it with the header that `genomctl header` prints now"
        ))
    }
}

/// Does it; where it fails, keeps why, and returns `otherwise`. A panic does not reach C.
pub(crate) fn guarded<R>(otherwise: R, work: impl FnOnce() -> Result<R, Failure>) -> R {
    let done = catch_unwind(AssertUnwindSafe(work));
    match done.unwrap_or_else(|_| Err(Failure::new("libgenomd_client has a defect: it panicked"))) {
        Ok(result) => result,
        Err(Failure(why)) => {
            let why = CString::new(why.replace('\0', " ")).unwrap_or_default();
            LAST.with(|last| last.replace(why));
            otherwise
        }
    }
}

/// The last one; an empty string if there is none.
pub(crate) fn last() -> *const c_char {
    LAST.with(|last| last.borrow().as_ptr())
}
