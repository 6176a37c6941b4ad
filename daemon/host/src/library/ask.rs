//! Finds out where a running thread executes, by a signal. One of the few unsafe modules.
//!
//! The signal's handler stores where it interrupted the thread, and stops the thread there until
//! the asking thread has inspected it. The signal is one that is ignored by default, so that a late
//! delivery does no harm.
#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ptr;
use std::sync::atomic::{AtomicI32, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

const SIGNAL: c_int = libc::SIGURG;
/// Timeout for the answer of a thread.
const PATIENCE: Duration = Duration::from_millis(200);
/// Longest time for which a thread is stopped, in nanoseconds.
const HELD: i64 = 500_000_000;

/// Where a thread executes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its program counter.
    pub(super) counter: usize,
    /// Its stack pointer.
    pub(super) stack: usize,
}

/// Id of the thread that is asked; 0 for none, which releases a stopped thread.
static ASKED: AtomicI32 = AtomicI32::new(0);
static COUNTER: AtomicUsize = AtomicUsize::new(0);
/// Stored last; 0 while there is no answer.
static STACK: AtomicUsize = AtomicUsize::new(0);

/// Calls `look` with the position of that thread, which is stopped meanwhile; `None` when the
/// thread does not answer in time.
pub(super) fn where_is<T>(thread: i32, look: impl FnOnce(Place) -> T) -> Option<T> {
    static TURN: Mutex<()> = Mutex::new(());
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    if is_masked(thread) || !handle() {
        return None;
    }
    STACK.store(0, Ordering::Relaxed);
    ASKED.store(thread, Ordering::Release);
    // SAFETY: sends a signal to a thread of this process, whose handler is `on_signal`.
    let sent = unsafe { libc::syscall(libc::SYS_tgkill, libc::getpid(), thread, SIGNAL) } == 0;
    let end = Instant::now() + PATIENCE;
    let mut found = None;
    while sent && found.is_none() && Instant::now() < end {
        match STACK.load(Ordering::Acquire) {
            0 => thread::park_timeout(Duration::from_micros(100)),
            stack => found = Some(Place { counter: COUNTER.load(Ordering::Relaxed), stack }),
        }
    }
    let seen = found.map(look);
    ASKED.store(0, Ordering::Release);
    seen
}

/// Whether the thread blocks the signal, which would then be handled at some later time.
fn is_masked(thread: i32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/self/task/{thread}/status"));
    let mask = status.ok().and_then(|status| {
        let line = status.lines().find_map(|line| line.strip_prefix("SigBlk:"))?;
        u64::from_str_radix(line.trim(), 16).ok()
    });
    mask.is_none_or(|mask| mask & (1 << (SIGNAL - 1)) != 0)
}

/// Installs the handler; `false` when the signal has another one.
fn handle() -> bool {
    let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = on_signal;
    // SAFETY: all zeroes is an action: an empty mask, no flags.
    let mut now: libc::sigaction = unsafe { MaybeUninit::zeroed().assume_init() };
    // SAFETY: without a new action, the system only writes the present one.
    if unsafe { libc::sigaction(SIGNAL, ptr::null(), &raw mut now) } != 0 {
        return false;
    }
    if now.sa_sigaction == handler as usize {
        return true;
    }
    if ![libc::SIG_DFL, libc::SIG_IGN].contains(&now.sa_sigaction) {
        return false;
    }
    now.sa_sigaction = handler as usize;
    now.sa_flags = libc::SA_SIGINFO | libc::SA_RESTART | libc::SA_ONSTACK;
    // SAFETY: the handler has the signature for SA_SIGINFO, calls only functions that are allowed
    // in handlers, and is part of this program, which is never unloaded.
    unsafe { libc::sigaction(SIGNAL, &raw const now, ptr::null_mut()) == 0 }
}

extern "C" fn on_signal(_: c_int, _: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: the system passes the context, as SA_SIGINFO requests; the other calls have no
    // preconditions.
    unsafe {
        let errno = *libc::__errno_location();
        let own = i32::try_from(libc::syscall(libc::SYS_gettid)).unwrap_or(0);
        if own != 0 && ASKED.load(Ordering::Acquire) == own {
            let (counter, stack) = registers(&*context.cast::<libc::ucontext_t>());
            COUNTER.store(counter, Ordering::Relaxed);
            STACK.store(stack, Ordering::Release);
            let begin = now();
            while ASKED.load(Ordering::Acquire) == own && now() - begin < HELD {
                libc::sched_yield();
            }
        }
        *libc::__errno_location() = errno;
    }
}

/// The monotonic clock in nanoseconds.
///
/// # Safety
/// No requirement; it calls only functions that are allowed in handlers.
unsafe fn now() -> i64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the system writes to a local variable.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut time) };
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}

/// Program counter and stack pointer.
#[cfg(target_arch = "x86_64")]
fn registers(context: &libc::ucontext_t) -> (usize, usize) {
    let of = |register: c_int| {
        let rank = usize::try_from(register).unwrap_or(0);
        context.uc_mcontext.gregs[rank].cast_unsigned() as usize
    };
    (of(libc::REG_RIP), of(libc::REG_RSP))
}

/// Program counter and stack pointer.
#[cfg(target_arch = "aarch64")]
fn registers(context: &libc::ucontext_t) -> (usize, usize) {
    (context.uc_mcontext.pc as usize, context.uc_mcontext.sp as usize)
}

/// Program counter and stack pointer: unknown on this platform, so that no use can be excluded.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn registers(_: &libc::ucontext_t) -> (usize, usize) {
    (0, 0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn a_thread_that_spins_says_where_it_is_and_goes_on() {
        let end = Arc::new(AtomicBool::new(false));
        let (sender, number) = channel();
        let spinning = std::thread::spawn({
            let end = Arc::clone(&end);
            move || {
                // SAFETY: it has no preconditions.
                let own = unsafe { libc::syscall(libc::SYS_gettid) };
                let here = 0_u8;
                sender.send((i32::try_from(own).unwrap(), ptr::from_ref(&here) as usize)).unwrap();
                while !end.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
                std::hint::black_box(here);
            }
        });
        let (number, there) = number.recv().unwrap();
        let place = where_is(number, |place| place).unwrap();
        assert!(place.stack.abs_diff(there) < 1 << 16, "{place:x?} {there:x}");
        assert_ne!(place.counter, 0);
        end.store(true, Ordering::Relaxed);
        spinning.join().unwrap();
        assert!(where_is(number, |place| place).is_none());
    }
}
