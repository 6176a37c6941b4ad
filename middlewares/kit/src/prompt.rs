//! Short time slices for threads that stand between a real-time thread and a middleware: they work
//! briefly, and should run as soon as they are woken.
//!
//! The one module of this crate with unsafe code: it calls the system.

#![allow(unsafe_code, reason = "no safe interface of sched_setattr(2) is kept up")]

use std::io;

/// A slice, in ns: the shortest that Linux grants.
const SLICE: u64 = 100_000;

/// Has the calling thread run soon when it is woken, among threads of the same nice value: its
/// turns are short, and Linux (from 6.12 on; before, nothing changes) prefers who asks for less.
/// It gets no more of the processor than before. Its policy and nice value stay, and so does a
/// thread of a real-time policy. See `sched_setattr(2)`, `sched_runtime` of `SCHED_OTHER`.
///
/// # Errors
/// The system refuses, for instance by a filter of system calls (seccomp).
pub fn be_prompt() -> io::Result<()> {
    let mut attributes = get()?;
    if attributes.sched_policy != SCHED_OTHER {
        return Ok(());
    }
    attributes.sched_runtime = SLICE;
    // SAFETY: the structure is whole, says its size, and is only read.
    let refused = unsafe { libc::syscall(libc::SYS_sched_setattr, THIS, &raw const attributes, 0) };
    if refused == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

const SCHED_OTHER: u32 = libc::SCHED_OTHER as u32;

/// The calling thread.
const THIS: libc::pid_t = 0;

fn get() -> io::Result<libc::sched_attr> {
    let size = u32::try_from(size_of::<libc::sched_attr>()).unwrap_or_default();
    // SAFETY: plain numbers, for which 0 is a value.
    let mut attributes: libc::sched_attr = unsafe { std::mem::zeroed() };
    // SAFETY: the structure has `size` bytes, and the system writes no more.
    let refused =
        unsafe { libc::syscall(libc::SYS_sched_getattr, THIS, &raw mut attributes, size, 0) };
    if refused == 0 { Ok(attributes) } else { Err(io::Error::last_os_error()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prompt_thread_asks_for_short_turns_and_nothing_else() {
        let before = get().unwrap();
        be_prompt().unwrap();
        let after = get().unwrap();
        assert_eq!(after.sched_policy, before.sched_policy);
        assert_eq!(after.sched_nice, before.sched_nice);
        // Older systems tell no slice.
        let wanted = if before.sched_runtime == 0 { 0 } else { SLICE };
        assert_eq!(after.sched_runtime, wanted);
    }
}
