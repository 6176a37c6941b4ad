//! A `sendto` for the whole program that mends what RustDDS sends wrongly ([`mended`]).
//!
//! RustDDS sends its datagrams with this function. On all other threads, and for all that needs no
//! mending, it calls the C library's.

use std::ffi::{c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};

use super::threads::is_rustdds;
use crate::filter::mended;

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
        if let Some(mended) = mended(message) {
            // SAFETY: the address is the caller's, the bytes are there until the call returns.
            let sent =
                unsafe { send(socket, mended.as_ptr().cast(), mended.len(), flags, to, size) };
            // The caller sees all of its bytes sent.
            let all = usize::try_from(sent).is_ok_and(|sent| sent == mended.len());
            return if all { libc::ssize_t::try_from(length).unwrap_or(sent) } else { sent };
        }
    }
    // SAFETY: the arguments are the caller's.
    unsafe { send(socket, bytes, length, flags, to, size) }
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
