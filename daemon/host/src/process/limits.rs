//! Resource limits of the process, kept as they were when the daemon started. One of the few unsafe
//! modules.
//!
//! A limit holds for the whole process: a codel that lowers one takes files or memory from the
//! daemon and all other components. Calls through the C library are refused; a limit lowered by a
//! direct system call is raised again.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::ptr;

use super::notes::{self, Act};
use crate::running;

/// `struct rlimit` of 64-bit systems.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Limit {
    soft: u64,
    hard: u64,
}

/// Limits that the daemon depends on. Others, such as that of core dumps, may be changed.
const NEEDED: [(c_int, &str); 8] = [
    (libc::RLIMIT_NOFILE as c_int, "RLIMIT_NOFILE"),
    (libc::RLIMIT_AS as c_int, "RLIMIT_AS"),
    (libc::RLIMIT_DATA as c_int, "RLIMIT_DATA"),
    (libc::RLIMIT_FSIZE as c_int, "RLIMIT_FSIZE"),
    (libc::RLIMIT_CPU as c_int, "RLIMIT_CPU"),
    (libc::RLIMIT_NPROC as c_int, "RLIMIT_NPROC"),
    (libc::RLIMIT_STACK as c_int, "RLIMIT_STACK"),
    (libc::RLIMIT_RTTIME as c_int, "RLIMIT_RTTIME"),
];

/// The limits at the start.
#[derive(Debug)]
pub(super) struct KeptLimits([Option<Limit>; NEEDED.len()]);

impl KeptLimits {
    pub(super) fn remember() -> Self {
        Self(NEEDED.map(|(resource, _)| exchange(resource, None)))
    }

    /// Raises limits that were lowered; returns a message for each.
    pub(super) fn put_back(&self) -> Vec<String> {
        let mut told = Vec::new();
        for (kept, (resource, name)) in self.0.iter().zip(NEEDED) {
            let (Some(kept), Some(now)) = (kept, exchange(resource, None)) else { continue };
            if now.soft >= kept.soft {
                continue;
            }
            let back = Limit { soft: kept.soft.min(now.hard), hard: now.hard };
            exchange(resource, Some(back));
            told.push(match exchange(resource, None) {
                Some(now) if now.soft >= kept.soft => {
                    format!("a codel lowered {name} of the process: it is put back")
                }
                _ => format!(
                    "a codel lowered {name} of the process for good: restart the daemon, and leave \
                     limits to who starts it"
                ),
            });
        }
        told
    }
}

/// Whether the processor time of this process or of a real-time thread is limited.
pub(super) fn of_time() -> bool {
    [libc::RLIMIT_CPU, libc::RLIMIT_RTTIME].iter().any(|resource| {
        exchange(*resource as c_int, None).is_some_and(|limit| limit.soft != libc::RLIM_INFINITY)
    })
}

/// The name of a limit.
pub(super) fn name(resource: c_int) -> String {
    let known = NEEDED.iter().find(|(number, _)| *number == resource);
    known.map_or_else(|| format!("limit {resource}"), |(_, name)| (*name).to_owned())
}

/// Sets a limit of this process, if `new` is given; returns the one before.
fn exchange(resource: c_int, new: Option<Limit>) -> Option<Limit> {
    let mut old = Limit::default();
    let new = new.as_ref().map_or(ptr::null(), ptr::from_ref);
    // SAFETY: both are null or point to limits.
    let done = unsafe { libc::syscall(libc::SYS_prlimit64, 0, resource, new, &raw mut old) };
    (done == 0).then_some(old)
}

/// Whether a codel is about to lower a limit that this process depends on.
///
/// # Safety
/// `new` is null or points to a limit.
unsafe fn is_refused(pid: libc::pid_t, resource: c_int, new: *const Limit) -> bool {
    let needed = NEEDED.iter().any(|(number, _)| *number == resource);
    // SAFETY: it has no preconditions.
    let ours = pid == 0 || pid == unsafe { libc::getpid() };
    if new.is_null() || !needed || !ours || !running::in_codel() {
        return false;
    }
    // SAFETY: the caller's promise.
    let new = unsafe { *new };
    let lowers = exchange(resource, None).is_some_and(|old| new.soft < old.soft);
    if lowers {
        notes::add(Act::Limit, resource, 0, running::words());
        // SAFETY: errno belongs to this thread.
        unsafe { *libc::__errno_location() = libc::EPERM };
    }
    lowers
}

/// The system's `setrlimit`, except that codels cannot lower a limit that the daemon depends on.
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn setrlimit(resource: c_int, new: *const Limit) -> c_int {
    // SAFETY: the caller's own arguments.
    unsafe { prlimit(0, resource, new, ptr::null_mut()) }
}

/// As [`setrlimit`].
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn setrlimit64(resource: c_int, new: *const Limit) -> c_int {
    // SAFETY: the caller's own arguments.
    unsafe { prlimit(0, resource, new, ptr::null_mut()) }
}

/// As [`setrlimit`].
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn prlimit(
    pid: libc::pid_t,
    resource: c_int,
    new: *const Limit,
    old: *mut Limit,
) -> c_int {
    // SAFETY: the caller's own arguments.
    unsafe {
        if is_refused(pid, resource, new) {
            return -1;
        }
        c_int::try_from(libc::syscall(libc::SYS_prlimit64, pid, resource, new, old)).unwrap_or(-1)
    }
}

/// As [`setrlimit`].
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn prlimit64(
    pid: libc::pid_t,
    resource: c_int,
    new: *const Limit,
    old: *mut Limit,
) -> c_int {
    // SAFETY: the caller's own arguments.
    unsafe { prlimit(pid, resource, new, old) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_was_lowered_is_raised_again() {
        let kept = KeptLimits::remember();
        let cpu = libc::RLIMIT_CPU as c_int;
        let before = exchange(cpu, None).unwrap();
        exchange(cpu, Some(Limit { soft: 100_000, ..before }));
        assert_eq!(kept.put_back(), ["a codel lowered RLIMIT_CPU of the process: it is put back"]);
        assert_eq!(exchange(cpu, None), Some(before));
        assert!(kept.put_back().is_empty());
    }
}
