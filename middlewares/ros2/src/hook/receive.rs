//! A `recvmsg` for the whole program, which shows what arrives to the guard before RustDDS has it.
//!
//! RustDDS takes its datagrams with this call, on one thread a participant, and offers no place to
//! look at them in between. The definition of a program goes before that of the C library. For all
//! other threads it is the C library's own.

use std::cell::RefCell;
use std::ffi::{c_int, c_void};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use super::threads::is_rustdds;
use crate::guard::{Guard, Limits, Tally};

type RecvMsg = unsafe extern "C" fn(c_int, *mut libc::msghdr, c_int) -> libc::ssize_t;

/// RustDDS takes all that a socket has before it looks at any of it: more than this, in datagrams
/// and in bytes, has to wait until it has. What waits is found with the next datagram.
const TURN: (usize, usize) = (4096, 32 << 20);

/// By domain: what peers may do, and where it is counted.
static DOMAINS: Mutex<Vec<(u16, Limits, Weak<Tally>)>> = Mutex::new(Vec::new());

/// Makes sure that [`recvmsg`] is part of the program: of what nothing refers to, the linker takes
/// nothing.
pub(super) fn link() {
    std::hint::black_box::<RecvMsg>(recvmsg);
}

/// Has the guard look at what participants receive that are made in a domain from now on.
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

/// As the system's, but that RustDDS hears nothing that the guard keeps from it.
///
/// # Safety
/// As for the system's: `message` tells of memory that may be written.
#[unsafe(no_mangle)]
unsafe extern "C" fn recvmsg(
    socket: c_int,
    message: *mut libc::msghdr,
    flags: c_int,
) -> libc::ssize_t {
    if !is_rustdds() {
        // SAFETY: the caller's own arguments.
        return unsafe { receive(socket, message, flags) };
    }
    let screened = GATE.try_with(|gate| {
        let mut gate = gate.try_borrow_mut().ok()?;
        let gate = gate.get_or_insert_with(|| Box::new(Gate::new(socket)));
        // SAFETY: the caller's own arguments.
        Some(unsafe { gate.receive(socket, message, flags) })
    });
    match screened {
        Ok(Some(received)) => received,
        // SAFETY: the caller's own arguments; on a thread that ends there is no guard any more.
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

    /// Receives the next datagram that RustDDS may hear.
    ///
    /// # Safety
    /// As for the system's.
    unsafe fn receive(
        &mut self,
        socket: c_int,
        message: *mut libc::msghdr,
        flags: c_int,
    ) -> libc::ssize_t {
        loop {
            if self.datagrams >= TURN.0 || self.bytes >= TURN.1 {
                (self.datagrams, self.bytes) = (0, 0);
                // SAFETY: the place of this thread's error number.
                unsafe { *libc::__errno_location() = libc::EAGAIN };
                return -1;
            }
            // SAFETY: the caller says that it may be read.
            let asked = unsafe { ptr::read(message) };
            // SAFETY: the caller's own arguments.
            let received = unsafe { receive(socket, message, flags) };
            let Ok(length) = usize::try_from(received) else {
                (self.datagrams, self.bytes) = (0, 0);
                return received;
            };
            self.datagrams += 1;
            // SAFETY: the system has filled it in; the buffer is the caller's, of that length.
            let datagram = unsafe { datagram(message, length) };
            // SAFETY: the system has filled in the address.
            let from = unsafe { address(&*message) };
            // What lies in several pieces RustDDS does not ask for.
            if datagram.is_none_or(|datagram| self.guard.screen(datagram, from, since_boot())) {
                self.bytes += length;
                return received;
            }
            // As if it had not come: the next one is asked for in the same words.
            // SAFETY: what the caller gave.
            unsafe { ptr::write(message, asked) };
        }
    }
}

/// The bytes of a datagram that was received into one buffer.
///
/// # Safety
/// `message` was filled in by the system with that many bytes, and nobody else has its buffer.
unsafe fn datagram<'a>(message: *const libc::msghdr, length: usize) -> Option<&'a mut [u8]> {
    // SAFETY: the caller says that it may be read.
    let message = unsafe { &*message };
    if message.msg_iovlen != 1 || message.msg_iov.is_null() {
        return None;
    }
    // SAFETY: there is one, as it says.
    let buffer = unsafe { ptr::read(message.msg_iov) };
    // A datagram that was cut off is longer than its buffer.
    let length = length.min(buffer.iov_len);
    // SAFETY: the buffer was given to be written, and nobody else has it during the call.
    Some(unsafe { std::slice::from_raw_parts_mut(buffer.iov_base.cast(), length) })
}

/// Who sent it, where that was asked for.
///
/// # Safety
/// `message` was filled in by the system.
unsafe fn address(message: &libc::msghdr) -> Option<IpAddr> {
    let (name, length) = (message.msg_name, message.msg_namelen as usize);
    if name.is_null() || length < size_of::<libc::sa_family_t>() {
        return None;
    }
    // SAFETY: each address begins with its family; of each family there is as much as is read.
    unsafe {
        match c_int::from(ptr::read_unaligned(name.cast::<libc::sa_family_t>())) {
            libc::AF_INET if length >= size_of::<libc::sockaddr_in>() => {
                let name = ptr::read_unaligned(name.cast::<libc::sockaddr_in>());
                Some(Ipv4Addr::from(u32::from_be(name.sin_addr.s_addr)).into())
            }
            libc::AF_INET6 if length >= size_of::<libc::sockaddr_in6>() => {
                let name = ptr::read_unaligned(name.cast::<libc::sockaddr_in6>());
                Some(Ipv6Addr::from(name.sin6_addr.s6_addr).into())
            }
            _ => None,
        }
    }
}

/// The domain of a socket: RTPS 9.6.1.1, 250 ports for each.
fn domain_of(socket: c_int) -> Option<u16> {
    // SAFETY: of numbers all of whose bytes may be zero.
    let mut name: libc::sockaddr_in = unsafe { std::mem::zeroed() };
    let mut length = libc::socklen_t::try_from(size_of_val(&name)).ok()?;
    // SAFETY: the system writes no more than that length.
    let told = unsafe { libc::getsockname(socket, (&raw mut name).cast(), &raw mut length) };
    let port = u16::from_be(name.sin_port);
    (told == 0).then_some(port.checked_sub(7400)? / 250)
}

/// The C library's own.
///
/// # Safety
/// As for the system's.
unsafe fn receive(socket: c_int, message: *mut libc::msghdr, flags: c_int) -> libc::ssize_t {
    static NEXT: AtomicPtr<c_void> = AtomicPtr::new(ptr::null_mut());
    let mut next = NEXT.load(Ordering::Relaxed);
    if next.is_null() {
        // SAFETY: looks a name up, behind the program's own definition.
        next = unsafe { libc::dlsym(libc::RTLD_NEXT, c"recvmsg".as_ptr()) };
        NEXT.store(next, Ordering::Relaxed);
    }
    if next.is_null() {
        // SAFETY: the same call, of a program that has no C library of its own to ask.
        return unsafe { libc::syscall(libc::SYS_recvmsg, socket, message, flags) }
            as libc::ssize_t;
    }
    // SAFETY: what goes by this name is of this type (POSIX).
    let next: RecvMsg = unsafe { std::mem::transmute(next) };
    // SAFETY: the caller's own arguments.
    unsafe { next(socket, message, flags) }
}

/// Time since the machine started, its sleep included.
fn since_boot() -> Duration {
    // SAFETY: of numbers all of whose bytes may be zero.
    let mut time: libc::timespec = unsafe { std::mem::zeroed() };
    // SAFETY: the system writes a time.
    unsafe { libc::clock_gettime(libc::CLOCK_BOOTTIME, &raw mut time) };
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    Duration::new(seconds, u32::try_from(time.tv_nsec).unwrap_or(0))
}
