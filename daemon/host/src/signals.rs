//! What the process does on signals, kept against codels that take the process for their own:
//! `signal(SIGTERM, SIG_IGN)` in a library is no reason that a daemon cannot be stopped. One of
//! the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::mem::MaybeUninit;
use std::ptr;

/// Signals that a daemon relies on: to be stopped, and not to die of a peer that left.
const OURS: [(c_int, &str); 3] =
    [(libc::SIGINT, "SIGINT"), (libc::SIGTERM, "SIGTERM"), (libc::SIGPIPE, "SIGPIPE")];

/// The process's own actions.
pub struct KeptSignals([Option<libc::sigaction>; OURS.len()]);

impl KeptSignals {
    /// The actions as they are now, which is to be after the process has set them up.
    #[must_use]
    pub fn remember() -> Self {
        Self(OURS.map(|(signal, _)| action(signal)))
    }

    /// Puts back what was changed; the names of these signals.
    pub fn put_back(&self) -> Vec<&'static str> {
        let changed = self.0.iter().zip(OURS).filter_map(|(kept, (signal, name))| {
            let kept = kept.as_ref()?;
            let same = action(signal)?.sa_sigaction == kept.sa_sigaction;
            // SAFETY: `kept` is an action that the system itself told, whose handler is code of
            // this process and not of a library that may be closed.
            let put = !same && unsafe { libc::sigaction(signal, kept, ptr::null_mut()) } == 0;
            put.then_some(name)
        });
        changed.collect()
    }
}

impl std::fmt::Debug for KeptSignals {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("KeptSignals")
    }
}

fn action(signal: c_int) -> Option<libc::sigaction> {
    let mut action = MaybeUninit::uninit();
    // SAFETY: without a new action the system only writes the present one, to where there is room.
    let told = unsafe { libc::sigaction(signal, ptr::null(), action.as_mut_ptr()) } == 0;
    // SAFETY: the system wrote it.
    told.then(|| unsafe { action.assume_init() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_somebody_changes_is_put_back_and_told_once() {
        // What runs in the background of a shell ignores SIGINT from the start.
        // SAFETY: the default calls nothing.
        unsafe { libc::signal(libc::SIGINT, libc::SIG_DFL) };
        let kept = KeptSignals::remember();
        assert_eq!(kept.put_back(), Vec::<&str>::new());
        // SAFETY: to ignore a signal calls nothing.
        let before = unsafe { libc::signal(libc::SIGINT, libc::SIG_IGN) };
        assert_eq!(kept.put_back(), ["SIGINT"]);
        assert_eq!(kept.put_back(), Vec::<&str>::new());
        assert_eq!(action(libc::SIGINT).map(|action| action.sa_sigaction), Some(before));
    }
}
