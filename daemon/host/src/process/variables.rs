//! Variables of the environment that are meant for this process alone. Changes the environment,
//! and so contains unsafe code.

#![allow(unsafe_code)]

use std::ffi::OsString;

/// Takes a variable out of the environment, so that neither codels nor children find it. To be
/// called before there are other threads: when there are some it stays where it is.
#[must_use]
pub fn take_variable(name: &str) -> Option<OsString> {
    let value = std::env::var_os(name)?;
    let alone = std::fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1);
    if alone {
        // SAFETY: this thread is the only one, so none reads or writes the environment meanwhile.
        unsafe { std::env::remove_var(name) };
    }
    Some(value)
}
