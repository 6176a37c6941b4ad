//! A `recvmsg` for the whole program that passes datagrams through the guard before RustDDS gets
//! them.
//!
//! RustDDS receives its datagrams with this function, on one thread per participant, and has no
//! interface for filtering them. A definition in the program takes precedence over the C library's.
//! On all other threads it calls the C library's.

use std::cell::RefCell;
use std::ffi::c_int;
use std::net::{IpAddr, Ipv4Addr};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use super::address;
use super::next::Next;
use super::since::since_boot;
use super::threads::is_rustdds;
use crate::filter::{Guard, Limits, Tally};

type RecvMsg = unsafe extern "C" fn(c_int, *mut libc::msghdr, c_int) -> libc::ssize_t;

/// Limits per turn, in datagrams and bytes: RustDDS reads everything that a socket has before it
/// processes any of it. What is left is read with the next datagram that arrives.
const TURN: (usize, usize) = (4096, 32 << 20);

/// Limits of peers and counters, by domain.
static DOMAINS: Mutex<Vec<(u16, Limits, Weak<Tally>)>> = Mutex::new(Vec::new());

/// Makes sure that [`recvmsg`] is part of the program: the linker drops objects that nothing refers
/// to.
pub(super) fn link() {
    std::hint::black_box::<RecvMsg>(recvmsg);
}

/// Makes the guard filter what participants receive that are created in this domain from now on.
pub(super) fn guard(domain: u16, limits: Limits) -> Arc<Tally> {
    let mut domains = DOMAINS.lock().unwrap_or_else(PoisonError::into_inner);
    let shared = domains.iter().find(|(number, ..)| *number == domain);
    let tally = shared.and_then(|(.., tally)| tally.upgrade()).unwrap_or_default();
    domains.retain(|(number, _, tally)| *number != domain && tally.strong_count() > 0);
    domains.push((domain, limits, Arc::downgrade(&tally)));
    tally
}

/// The guard of a participant, on the thread that receives for it.
struct Gate {
    guard: Guard,
    datagrams: usize,
    bytes: usize,
}

thread_local! {
    static GATE: RefCell<Option<Box<Gate>>> = const { RefCell::new(None) };
}

/// Behaves as the system's, except that RustDDS does not get what the guard refuses.
///
/// # Safety
/// The same as for the system's: `message` refers to writable memory.
#[unsafe(no_mangle)]
unsafe extern "C" fn recvmsg(
    socket: c_int,
    message: *mut libc::msghdr,
    flags: c_int,
) -> libc::ssize_t {
    if !is_rustdds() {
        // SAFETY: the arguments are the caller's.
        return unsafe { receive(socket, message, flags) };
    }
    let screened = GATE.try_with(|gate| {
        let mut gate = gate.try_borrow_mut().ok()?;
        let gate = gate.get_or_insert_with(|| Box::new(Gate::new(socket)));
        // SAFETY: the arguments are the caller's.
        Some(unsafe { gate.receive(socket, message, flags) })
    });
    match screened {
        Ok(Some(received)) => received,
        // SAFETY: the arguments are the caller's. On a thread that is ending the guard no longer
        // exists.
        _ => unsafe { receive(socket, message, flags) },
    }
}

impl Gate {
    fn new(socket: c_int) -> Self {
        let domains = DOMAINS.lock().unwrap_or_else(PoisonError::into_inner);
        let found = domain_of(socket)
            .and_then(|domain| domains.iter().find(|(number, ..)| *number == domain));
        let (limits, tally) = match found {
            Some((_, limits, tally)) => (*limits, tally.upgrade().unwrap_or_default()),
            None => Default::default(),
        };
        Self { guard: Guard::new(limits, tally), datagrams: 0, bytes: 0 }
    }

    /// Receives the next datagram that RustDDS may get.
    ///
    /// # Safety
    /// The same as for the system's.
    unsafe fn receive(
        &mut self,
        socket: c_int,
        message: *mut libc::msghdr,
        flags: c_int,
    ) -> libc::ssize_t {
        loop {
            if self.datagrams >= TURN.0 || self.bytes >= TURN.1 {
                (self.datagrams, self.bytes) = (0, 0);
                // SAFETY: writes this thread's `errno`.
                unsafe { *libc::__errno_location() = libc::EAGAIN };
                return -1;
            }
            // SAFETY: the caller guarantees that it can be read.
            let asked = unsafe { ptr::read(message) };
            // SAFETY: the arguments are the caller's.
            let received = unsafe { receive(socket, message, flags) };
            let Ok(length) = usize::try_from(received) else {
                (self.datagrams, self.bytes) = (0, 0);
                return received;
            };
            self.datagrams += 1;
            // SAFETY: the system has filled it in; the buffer is the caller's and has that length.
            let datagram = unsafe { datagram(message, length) };
            // SAFETY: the system has filled in the address, if the caller asked for it.
            let from = unsafe { address::read((*message).msg_name.cast(), (*message).msg_namelen) };
            let from = from.map(|from| from.ip());
            let known = datagram.is_some() && matches!(from, Some(IpAddr::V4(_)));
            // `None` if it is split over several buffers, which RustDDS never asks for.
            let mut screen = |datagram: &mut [u8]| {
                self.guard.screen(datagram, from, since_boot(), &mut super::send::repair)
            };
            if datagram.is_none_or(&mut screen) {
                self.bytes += length;
                if known && self.guard.needs_loopback() {
                    // SAFETY: the system has filled in an IPv4 address, which is the caller's.
                    unsafe { put_loopback(&*message) };
                }
                return received;
            }
            // Dropped: receive the next one with the same arguments.
            // SAFETY: writes back what the caller gave.
            unsafe { ptr::write(message, asked) };
        }
    }
}

/// The bytes of a datagram that was received into one buffer.
///
/// # Safety
/// The system filled in `message` with `length` bytes, and nobody else accesses its buffer.
unsafe fn datagram<'a>(message: *const libc::msghdr, length: usize) -> Option<&'a mut [u8]> {
    // SAFETY: the caller guarantees that it can be read.
    let message = unsafe { &*message };
    if message.msg_iovlen != 1 || message.msg_iov.is_null() {
        return None;
    }
    // SAFETY: there is one, according to the length.
    let buffer = unsafe { ptr::read(message.msg_iov) };
    // A truncated datagram is longer than its buffer.
    let length = length.min(buffer.iov_len);
    // SAFETY: the buffer is writable, and nobody else accesses it during the call.
    Some(unsafe { std::slice::from_raw_parts_mut(buffer.iov_base.cast(), length) })
}

/// Makes the sender's address, which is an IPv4 one, that of the loopback interface.
///
/// # Safety
/// The system filled in `message` with such an address, which nobody else accesses.
unsafe fn put_loopback(message: &libc::msghdr) {
    let name = message.msg_name.cast::<libc::sockaddr_in>();
    let address = u32::from(Ipv4Addr::LOCALHOST).to_be();
    // SAFETY: the caller guarantees that there is one.
    unsafe { ptr::write_unaligned(&raw mut (*name).sin_addr.s_addr, address) };
}

/// The domain of a socket, from its port: RTPS 9.6.1.1, 250 ports per domain.
fn domain_of(socket: c_int) -> Option<u16> {
    // SAFETY: all members are integers, for which zero is a valid value.
    let mut name: libc::sockaddr_in = unsafe { std::mem::zeroed() };
    let mut length = libc::socklen_t::try_from(size_of_val(&name)).ok()?;
    // SAFETY: the system writes no more than `length` bytes.
    let told = unsafe { libc::getsockname(socket, (&raw mut name).cast(), &raw mut length) };
    let port = u16::from_be(name.sin_port);
    (told == 0).then_some(port.checked_sub(7400)? / 250)
}

/// Calls the C library's `recvmsg`.
///
/// # Safety
/// The same as for the system's.
unsafe fn receive(socket: c_int, message: *mut libc::msghdr, flags: c_int) -> libc::ssize_t {
    static NEXT: Next = Next::new(c"recvmsg");
    let next = NEXT.get();
    if next.is_null() {
        // SAFETY: the same call, directly to the system, in a statically linked program.
        return unsafe { libc::syscall(libc::SYS_recvmsg, socket, message, flags) }
            as libc::ssize_t;
    }
    // SAFETY: the function of this name has this type (POSIX).
    let next: RecvMsg = unsafe { std::mem::transmute(next) };
    // SAFETY: the arguments are the caller's.
    unsafe { next(socket, message, flags) }
}
