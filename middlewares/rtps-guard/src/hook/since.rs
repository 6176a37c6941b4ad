//! The clock by which the filter measures.

use std::time::Duration;

/// Time since boot, including suspend.
pub(super) fn since_boot() -> Duration {
    // SAFETY: all members are integers, for which zero is a valid value.
    let mut time: libc::timespec = unsafe { std::mem::zeroed() };
    // SAFETY: the system writes a time.
    unsafe { libc::clock_gettime(libc::CLOCK_BOOTTIME, &raw mut time) };
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    Duration::new(seconds, u32::try_from(time.tv_nsec).unwrap_or(0))
}
