//! Child processes that codels fork. One of the few unsafe modules.
//!
//! A child inherits the daemon's descriptors, which stay open as long as it lives: its listening
//! sockets would accept clients that nobody serves, its locks would block the next daemon. So each
//! child closes the daemon's own descriptors. Children that execute another program lose them
//! anyway: all are close-on-exec.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_int, c_uint};
use std::os::fd::{AsFd, AsRawFd as _};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::running;

/// Descriptors below this number are tracked.
const MOST: usize = 1 << 16;

/// A bit for each descriptor that children close.
static OWN: [AtomicU64; MOST / 64] = [const { AtomicU64::new(0) }; MOST / 64];

/// Whether this process is a child of the daemon.
static CHILD: AtomicBool = AtomicBool::new(false);

/// Makes children that codels fork close this descriptor.
pub fn keep_from_children(descriptor: impl AsFd) {
    prepare();
    let number = usize::try_from(descriptor.as_fd().as_raw_fd()).unwrap_or(MOST);
    if let Some(word) = OWN.get(number / 64) {
        word.fetch_or(1 << (number % 64), Ordering::AcqRel);
    }
}

/// Stops tracking a descriptor that is about to be closed, since its number will be reused.
pub(super) fn forget(descriptor: c_int) {
    let Ok(number) = usize::try_from(descriptor) else { return };
    let Some(word) = OWN.get(number / 64) else { return };
    let bit = 1 << (number % 64);
    if word.load(Ordering::Relaxed) & bit != 0 {
        word.fetch_and(!bit, Ordering::AcqRel);
    }
}

/// Installs the fork handler.
pub(super) fn prepare() {
    static ONCE: Once = Once::new();
    // SAFETY: the handler calls only functions that are allowed in a child of a process with
    // threads, and is part of this program.
    ONCE.call_once(|| unsafe {
        libc::pthread_atfork(None, None, Some(on_child));
    });
}

/// Whether this process is a child that a codel forked.
#[inline]
pub(crate) fn is_child() -> bool {
    CHILD.load(Ordering::Relaxed)
}

unsafe extern "C" fn on_child() {
    CHILD.store(true, Ordering::Relaxed);
    for (at, word) in OWN.iter().enumerate() {
        let mut bits = word.load(Ordering::Relaxed);
        while bits != 0 {
            let number = at * 64 + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            // SAFETY: closes the child's own copy of the descriptor; no code of the daemon runs in
            // the child.
            unsafe { libc::syscall(libc::SYS_close, number) };
        }
    }
}

/// The system's `open`, except that what the daemon and its libraries open is close-on-exec.
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn open(path: *const c_char, flags: c_int, mode: c_uint) -> c_int {
    let flags = if running::in_codel() { flags } else { flags | libc::O_CLOEXEC };
    let (call, here) = (libc::SYS_openat, libc::AT_FDCWD);
    // SAFETY: the caller's own arguments.
    c_int::try_from(unsafe { libc::syscall(call, here, path, flags, mode) }).unwrap_or(-1)
}

/// As [`open`].
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn open64(path: *const c_char, flags: c_int, mode: c_uint) -> c_int {
    // SAFETY: the caller's own arguments.
    unsafe { open(path, flags, mode) }
}

/// As [`open`], for sockets.
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn socket(domain: c_int, kind: c_int, protocol: c_int) -> c_int {
    let kind = if running::in_codel() { kind } else { kind | libc::SOCK_CLOEXEC };
    // SAFETY: the caller's own arguments.
    let made = unsafe { libc::syscall(libc::SYS_socket, domain, kind, protocol) };
    c_int::try_from(made).unwrap_or(-1)
}

/// As [`open`], for pairs of sockets.
///
/// # Safety
/// As for the system's function.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn socketpair(
    domain: c_int,
    kind: c_int,
    protocol: c_int,
    both: *mut c_int,
) -> c_int {
    let kind = if running::in_codel() { kind } else { kind | libc::SOCK_CLOEXEC };
    // SAFETY: the caller's own arguments.
    let made = unsafe { libc::syscall(libc::SYS_socketpair, domain, kind, protocol, both) };
    c_int::try_from(made).unwrap_or(-1)
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;
    use std::os::unix::net::UnixStream;

    use super::*;

    #[test]
    fn a_child_does_not_keep_the_daemons_connections_open() {
        let (mut near, far) = UnixStream::pair().unwrap();
        keep_from_children(&far);
        // SAFETY: the child only sleeps.
        let child = unsafe {
            let child = libc::fork();
            if child == 0 {
                libc::pause();
            }
            child
        };
        drop(far);
        // The end of the stream is seen although the child lives.
        assert_eq!(near.read(&mut [0]).unwrap(), 0);
        // SAFETY: the child was forked here.
        unsafe {
            libc::kill(child, libc::SIGKILL);
            libc::waitpid(child, std::ptr::null_mut(), 0);
        }
    }
}
