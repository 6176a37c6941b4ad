//! An `epoll_wait` for the whole program that signals do not cut short for RustDDS.
//!
//! A debugger that attaches, Ctrl-Z and `fg`, the machine's sleep, and timers of codels interrupt
//! the waits of all threads. RustDDS 0.15 takes that for the end: its threads are gone, without a
//! word, and ROS 2 is silent (`rtps/dp_event_loop.rs`, `discovery/discovery.rs`). The definition of
//! a program goes before that of the C library. For all other threads, it is the same.

use std::ffi::c_int;
use std::io;
use std::ptr;
use std::time::{Duration, Instant};

use super::threads::is_rustdds;

type EpollWait = unsafe extern "C" fn(c_int, *mut libc::epoll_event, c_int, c_int) -> c_int;

/// Makes sure that [`epoll_wait`] is part of the program: of what nothing refers to, the linker
/// takes nothing.
pub(super) fn link() {
    std::hint::black_box::<EpollWait>(epoll_wait);
}

/// As the system's, but that it goes on for the rest of the time when RustDDS is interrupted.
///
/// # Safety
/// As for the system's: `events` has room for `most`.
#[unsafe(no_mangle)]
unsafe extern "C" fn epoll_wait(
    epoll: c_int,
    events: *mut libc::epoll_event,
    most: c_int,
    timeout: c_int,
) -> c_int {
    // Only a wait with a finite timeout has a deadline: 0 does not wait, and -1 waits for ever.
    let time = u64::try_from(timeout).ok().filter(|time| *time > 0).map(Duration::from_millis);
    let end = time.map(|time| Instant::now() + time);
    let mut left = timeout;
    loop {
        // SAFETY: the caller's own arguments; without a mask of signals it is the same call.
        let ready = unsafe { libc::epoll_pwait(epoll, events, most, left, ptr::null()) };
        let interrupted =
            ready < 0 && io::Error::last_os_error().kind() == io::ErrorKind::Interrupted;
        if !interrupted || !is_rustdds() {
            return ready;
        }
        if let Some(end) = end {
            // Rounded up: who waits for a date shall not wake before it.
            let rest = end.saturating_duration_since(Instant::now());
            let rest = rest.as_micros().div_ceil(1000);
            left = c_int::try_from(rest).unwrap_or(c_int::MAX);
        }
    }
}
