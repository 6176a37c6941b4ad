//! A `sendto` for the whole program that mends what RustDDS sends wrongly ([`mended`]), too early, in
//! too small parts or too fast ([`Outgoing`]).
//!
//! RustDDS sends its datagrams with this function. On all other threads, and for all that needs no
//! mending, it calls the C library's.

use std::cell::RefCell;
use std::ffi::{c_int, c_void};
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use super::address;
use super::next::Next;
use super::since::since_boot;
use super::threads::is_rustdds;
use crate::filter::{Lack, Outgoing, Target, Wire, mended};

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

/// Behaves as the system's, except that readers understand the replies of RustDDS, and can take its
/// large samples.
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
        // SAFETY: the address is the caller's.
        let part = match unsafe { address::read(to, size) } {
            Some(SocketAddr::V4(address)) => {
                let to = Target { socket, address };
                with_outgoing(|all| all.send_part(&to, meant, &mut Sockets)).flatten()
            }
            _ => None,
        };
        match part {
            Some(true) => {}
            Some(false) => return -1,
            None => {
                let narrowed = with_outgoing(|all| all.announced.narrowed(meant, since_boot));
                let narrowed = narrowed.flatten();
                let out = narrowed.as_deref().unwrap_or(meant);
                // SAFETY: the address is the caller's, the bytes are there until the call returns.
                let sent = unsafe { send(socket, out.as_ptr().cast(), out.len(), flags, to, size) };
                if sent < 0 {
                    return sent;
                }
            }
        }
        with_outgoing(|all| all.announced.sent(meant));
        // The caller sees all of its bytes sent.
        return libc::ssize_t::try_from(length).unwrap_or(libc::ssize_t::MAX);
    }
    // SAFETY: the arguments are the caller's.
    unsafe { send(socket, bytes, length, flags, to, size) }
}

thread_local! {
    /// What the participant of this thread sends: each has a thread that receives and sends for it.
    static OUTGOING: RefCell<Outgoing> = RefCell::default();
}

/// `None` on a thread that is ending.
fn with_outgoing<R>(work: impl FnOnce(&mut Outgoing) -> R) -> Option<R> {
    let worked =
        OUTGOING.try_with(|outgoing| outgoing.try_borrow_mut().ok().map(|mut of| work(&mut of)));
    worked.ok().flatten()
}

/// A reader lacks parts of a sample of the participant whose thread this is. Returns whether they
/// were sent again.
pub(super) fn repair(reader: Option<IpAddr>, lack: &Lack) -> bool {
    with_outgoing(|all| all.repair(reader, lack, &mut Sockets)).unwrap_or(false)
}

/// The participant's sockets.
struct Sockets;

impl Wire for Sockets {
    fn send(&mut self, to: &Target, bytes: &[u8]) -> bool {
        // SAFETY: all members are integers, for which zero is a valid value.
        let mut address: libc::sockaddr_in = unsafe { std::mem::zeroed() };
        address.sin_family = libc::sa_family_t::try_from(libc::AF_INET).unwrap_or_default();
        address.sin_port = to.address.port().to_be();
        address.sin_addr.s_addr = u32::from(*to.address.ip()).to_be();
        let size = libc::socklen_t::try_from(size_of_val(&address)).unwrap_or_default();
        let (from, to_address) = (bytes.as_ptr().cast(), (&raw const address).cast());
        let flags = libc::MSG_NOSIGNAL;
        // SAFETY: the bytes and the address are there until the call returns.
        let sent = unsafe { send(to.socket, from, bytes.len(), flags, to_address, size) };
        sent >= 0
    }

    fn now(&self) -> Duration {
        since_boot()
    }

    fn pause(&mut self, time: Duration) {
        // No event tells that a reader has taken what was sent.
        std::thread::park_timeout(time);
    }
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
    static NEXT: Next = Next::new(c"sendto");
    let next = NEXT.get();
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
