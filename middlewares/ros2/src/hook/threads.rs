//! Which threads are RustDDS's own.

use std::cell::Cell;

/// How the names of its threads begin.
const RUSTDDS: &[u8] = b"RustDDS ";

thread_local! {
    /// Whether this is one, once that was looked at.
    static OURS: Cell<Option<bool>> = const { Cell::new(None) };
}

/// Whether this is a thread of RustDDS's: it has its name before it does anything.
pub(super) fn is_rustdds() -> bool {
    let looked = || {
        // With its end, the name of a thread has at most 16 bytes.
        let mut name = [0_u8; 16];
        // SAFETY: the system writes no more than that.
        let told = unsafe { libc::prctl(libc::PR_GET_NAME, name.as_mut_ptr()) };
        told == 0 && name.starts_with(RUSTDDS)
    };
    OURS.with(|ours| {
        let is = ours.get().unwrap_or_else(looked);
        ours.set(Some(is));
        is
    })
}
