//! An `epoll_wait` for the whole program that continues after signals on RustDDS's threads.
//!
//! A debugger that attaches, Ctrl-Z and `fg`, system suspend, and timers of codels interrupt the
//! waits of all threads (EINTR). RustDDS 0.15 treats that as the end: its threads exit without an
//! error, and ROS 2 falls silent (`rtps/dp_event_loop.rs`, `discovery/discovery.rs`). A definition
//! in the program takes precedence over the C library's. On all other threads it behaves the same.

use std::ffi::c_int;
use std::io;
use std::ptr;
use std::time::{Duration, Instant};

use super::threads::is_rustdds;

type EpollWait = unsafe extern "C" fn(c_int, *mut libc::epoll_event, c_int, c_int) -> c_int;

/// Makes sure that [`epoll_wait`] is part of the program: the linker drops objects that nothing
/// refers to.
pub(super) fn link() {
    std::hint::black_box::<EpollWait>(epoll_wait);
}

/// Behaves as the system's, except that it waits for the rest of the time if RustDDS is
/// interrupted.
///
/// # Safety
/// The same as for the system's: `events` has room for `most` events.
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
        // SAFETY: the arguments are the caller's; without a signal mask it is the same call.
        let ready = unsafe { libc::epoll_pwait(epoll, events, most, left, ptr::null()) };
        let interrupted =
            ready < 0 && io::Error::last_os_error().kind() == io::ErrorKind::Interrupted;
        if !interrupted || !is_rustdds() {
            return ready;
        }
        if let Some(end) = end {
            // Rounded up, so that the caller does not wake before its deadline.
            let rest = end.saturating_duration_since(Instant::now());
            let rest = rest.as_micros().div_ceil(1000);
            left = c_int::try_from(rest).unwrap_or(c_int::MAX);
        }
    }
}
