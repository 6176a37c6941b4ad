//! Recognises RustDDS's own threads.

use std::cell::Cell;

/// Prefix of their names.
const RUSTDDS: &[u8] = b"RustDDS ";

thread_local! {
    /// Whether this thread is one; `None` until it was checked.
    static OURS: Cell<Option<bool>> = const { Cell::new(None) };
}

/// Whether this thread is RustDDS's. Its name is set before it does anything.
pub(super) fn is_rustdds() -> bool {
    let looked = || {
        // A thread's name has at most 16 bytes including the NUL.
        let mut name = [0_u8; 16];
        // SAFETY: the system writes at most 16 bytes.
        let told = unsafe { libc::prctl(libc::PR_GET_NAME, name.as_mut_ptr()) };
        told == 0 && name.starts_with(RUSTDDS)
    };
    OURS.with(|ours| {
        let is = ours.get().unwrap_or_else(looked);
        ours.set(Some(is));
        is
    })
}
