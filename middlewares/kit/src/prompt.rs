//! Short time slices for threads between a real-time thread and a middleware: these run briefly and
//! should start as soon as they are woken.
//!
//! The only module of this crate with unsafe code: it makes a system call.

#![allow(unsafe_code, reason = "no safe interface of sched_setattr(2) is kept up")]

use std::io;

/// Time slice in ns: the shortest that Linux grants.
const SLICE: u64 = 100_000;

/// Makes the calling thread run soon after it is woken, compared with threads of the same nice
/// value. Since 6.12 Linux prefers threads that ask for a shorter slice; older versions ignore it.
/// The thread's share of the processor, its policy and its nice value stay the same, and threads
/// with a real-time policy are left alone. See `sched_setattr(2)`, `sched_runtime` for
/// `SCHED_OTHER`.
///
/// # Errors
/// The system refuses, for instance because of a filter of system calls (seccomp).
pub fn be_prompt() -> io::Result<()> {
    let mut attributes = get()?;
    if attributes.sched_policy != SCHED_OTHER {
        return Ok(());
    }
    attributes.sched_runtime = SLICE;
    // SAFETY: the structure is initialised, states its size, and is only read by the kernel.
    let refused = unsafe { libc::syscall(libc::SYS_sched_setattr, THIS, &raw const attributes, 0) };
    if refused == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

const SCHED_OTHER: u32 = libc::SCHED_OTHER as u32;

/// Stands for the calling thread in these system calls.
const THIS: libc::pid_t = 0;

fn get() -> io::Result<libc::sched_attr> {
    let size = u32::try_from(size_of::<libc::sched_attr>()).unwrap_or_default();
    // SAFETY: all members are integers, for which zero is a valid value.
    let mut attributes: libc::sched_attr = unsafe { std::mem::zeroed() };
    // SAFETY: the structure has `size` bytes, and the kernel writes no more than that.
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
        // Older kernels report no slice.
        let wanted = if before.sched_runtime == 0 { 0 } else { SLICE };
        assert_eq!(after.sched_runtime, wanted);
    }
}
