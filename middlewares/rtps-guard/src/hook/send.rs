//! A `sendto` for the whole program that mends what RustDDS sends wrongly ([`mended`]) or too early
//! ([`Announced`]).
//!
//! RustDDS sends its datagrams with this function. On all other threads, and for all that needs no
//! mending, it calls the C library's.

use std::cell::RefCell;
use std::ffi::{c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};

use super::since::since_boot;
use super::threads::is_rustdds;
use crate::filter::{Announced, mended};

type SendTo = unsafe extern "C" fn(
    c_int,
    *const c_void,
    libc::size_t,
    c_int,
    *const libc::sockaddr,
    libc::socklen_t,
) -> libc::ssize_t;

/// Makes sure that [`sendto`] is part of the program.
pub(super) fn link() {
    std::hint::black_box::<SendTo>(sendto);
}

/// Behaves as the system's, except that readers understand the replies of RustDDS.
///
/// # Safety
/// The same as for the system's: `bytes` refers to `length` readable bytes, `to` to an address.
#[unsafe(no_mangle)]
unsafe extern "C" fn sendto(
    socket: c_int,
    bytes: *const c_void,
    length: libc::size_t,
    flags: c_int,
    to: *const libc::sockaddr,
    size: libc::socklen_t,
) -> libc::ssize_t {
    if is_rustdds() && !bytes.is_null() {
        // SAFETY: the caller guarantees that they can be read.
        let message = unsafe { std::slice::from_raw_parts(bytes.cast::<u8>(), length) };
        let mended = mended(message);
        let meant = mended.as_deref().unwrap_or(message);
        let narrowed = with_announced(|announced| announced.narrowed(meant, since_boot));
        let narrowed = narrowed.flatten();
        let out = narrowed.as_deref().unwrap_or(meant);
        // SAFETY: the address is the caller's, the bytes are there until the call returns.
        let sent = unsafe { send(socket, out.as_ptr().cast(), out.len(), flags, to, size) };
        if usize::try_from(sent).is_ok_and(|sent| sent == out.len()) {
            with_announced(|announced| announced.sent(meant));
            // The caller sees all of its bytes sent.
            return libc::ssize_t::try_from(length).unwrap_or(sent);
        }
        return sent;
    }
    // SAFETY: the arguments are the caller's.
    unsafe { send(socket, bytes, length, flags, to, size) }
}

thread_local! {
    /// What the participant of this thread has sent: each has a thread that sends for it.
    static ANNOUNCED: RefCell<Announced> = RefCell::default();
}

/// `None` on a thread that is ending.
fn with_announced<R>(work: impl FnOnce(&mut Announced) -> R) -> Option<R> {
    let worked =
        ANNOUNCED.try_with(|announced| announced.try_borrow_mut().ok().map(|mut of| work(&mut of)));
    worked.ok().flatten()
}

/// Calls the C library's `sendto`.
///
/// # Safety
/// The same as for the system's.
unsafe fn send(
    socket: c_int,
    bytes: *const c_void,
    length: libc::size_t,
    flags: c_int,
    to: *const libc::sockaddr,
    size: libc::socklen_t,
) -> libc::ssize_t {
    static NEXT: AtomicPtr<c_void> = AtomicPtr::new(ptr::null_mut());
    let mut next = NEXT.load(Ordering::Relaxed);
    if next.is_null() {
        // SAFETY: looks up a name after the program's own definition.
        next = unsafe { libc::dlsym(libc::RTLD_NEXT, c"sendto".as_ptr()) };
        NEXT.store(next, Ordering::Relaxed);
    }
    if next.is_null() {
        // SAFETY: the same call, directly to the system, in a statically linked program.
        return unsafe { libc::syscall(libc::SYS_sendto, socket, bytes, length, flags, to, size) }
            as libc::ssize_t;
    }
    // SAFETY: the function of this name has this type (POSIX).
    let next: SendTo = unsafe { std::mem::transmute(next) };
    // SAFETY: the arguments are the caller's.
    unsafe { next(socket, bytes, length, flags, to, size) }
}
