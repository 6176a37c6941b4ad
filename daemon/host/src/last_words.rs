//! Reports on standard error when foreign code ends the process: which codel, of which library, and
//! how. Without this report, a crash would not show which of many codels caused it.
//!
//! It does not prevent anything: the process ends as it would have. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::crash_note;
use crate::process;
use crate::running::{is_own_process, note_own_process, words};

/// Signals that end a process because of an error in its code.
const FAULTS: [c_int; 7] = [
    libc::SIGSEGV,
    libc::SIGBUS,
    libc::SIGFPE,
    libc::SIGILL,
    libc::SIGABRT,
    libc::SIGSYS,
    libc::SIGTRAP,
];

/// Actions of these signals before ours were installed.
static BEFORE: OnceLock<[Option<libc::sigaction>; FAULTS.len()]> = OnceLock::new();

/// The daemon is ending normally: no report from here on.
static ENDS_WELL: AtomicBool = AtomicBool::new(false);

/// Ends the process as if this thread of it had called `abort`, so that the report shows where the
/// thread is; `None` for the calling one. A thread that blocks the signal lives on.
pub fn abort_in(thread: Option<u32>) {
    let thread = thread.and_then(|thread| i32::try_from(thread).ok());
    // SAFETY: sends a signal to a thread of this process, if there is such a thread, else to the
    // process; its handler is ours.
    unsafe {
        let own = libc::getpid();
        let thread = thread.unwrap_or_else(|| libc::gettid());
        if libc::syscall(libc::SYS_tgkill, own, thread, libc::SIGABRT) != 0 {
            libc::kill(own, libc::SIGABRT);
        }
    }
}

/// Installs the reports. Further calls do nothing.
pub fn tell_last_words() {
    BEFORE.get_or_init(|| {
        // SAFETY: the handler calls only functions that are allowed in handlers; it is part of this
        // program, which is never unloaded.
        unsafe { libc::atexit(on_exit) };
        note_own_process();
        FAULTS.map(handle)
    });
}

fn handle(signal: c_int) -> Option<libc::sigaction> {
    let mut before = MaybeUninit::uninit();
    // SAFETY: all zeroes is an action: an empty mask, no flags.
    let mut action: libc::sigaction = unsafe { MaybeUninit::zeroed().assume_init() };
    let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = on_fault;
    action.sa_sigaction = handler as usize;
    // On the alternate stack that each thread has: the normal one may have overflowed.
    action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
    // SAFETY: the handler has the signature that SA_SIGINFO asks for, see above for the rest.
    let done = unsafe { libc::sigaction(signal, &raw const action, before.as_mut_ptr()) } == 0;
    // SAFETY: the system wrote it.
    done.then(|| unsafe { before.assume_init() })
}

extern "C" fn on_fault(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    let rank = FAULTS.iter().position(|known| *known == signal);
    let name = process::signal_name(signal).unwrap_or("a signal");
    say(name, " in ");
    // SAFETY: the arguments of this handler, which is installed with SA_SIGINFO.
    unsafe { crash_note::of_signal(name, signal, info, context) };
    // SAFETY: the argument of this handler.
    let was_sent = unsafe { (*info).si_code } <= 0;
    // The standard library's action waits for a fault to happen again, which what was sent does not.
    let before = BEFORE.get().zip(rank).filter(|_| !was_sent);
    let before = before.and_then(|(all, rank)| all.get(rank)?.as_ref());
    // SAFETY: restores an action that the system knows; a fault then happens again.
    unsafe {
        match before {
            Some(before) => libc::sigaction(signal, before, ptr::null_mut()),
            None => libc::signal(signal, libc::SIG_DFL) as c_int,
        };
        if was_sent {
            libc::raise(signal);
        }
    }
}

/// The daemon has stopped everything and ends, with any status.
pub fn end_is_ours() {
    ENDS_WELL.store(true, Ordering::Release);
}

/// Called at `exit`, which foreign code called unless the daemon ends normally.
extern "C" fn on_exit() {
    if genom_host_process_ends(c"exit".as_ptr()) {
        // SAFETY: threads of the daemon still run, so no further exit handlers are run; the status
        // tells the parent that the daemon failed.
        unsafe { libc::_exit(1) };
    }
}

/// Reports who ends the process by the function `how`, unless it is a child process or ends
/// normally; returns whether it reported.
#[unsafe(no_mangle)]
extern "C" fn genom_host_process_ends(how: *const c_char) -> bool {
    static SAID: AtomicBool = AtomicBool::new(false);
    if ENDS_WELL.load(Ordering::Acquire) || !is_own_process() {
        return false;
    }
    if !SAID.swap(true, Ordering::AcqRel) {
        // SAFETY: the callers pass a C string.
        let how = unsafe { CStr::from_ptr(how) }.to_str().unwrap_or_default();
        say(how, " called by ");
        crash_note::of_call(how);
    }
    true
}

/// A codel's thread is being cancelled: the process cannot continue.
#[unsafe(no_mangle)]
extern "C" fn genom_host_thread_ends() {
    say("pthread_cancel", " in ");
    crash_note::of_call("pthread_cancel");
}

/// Ends a child that a codel forked and that returned from the codel: it must not continue as a
/// daemon.
#[cold]
pub(crate) fn child_came_back() -> ! {
    write(&["genomd: a child that ", words(), " forked came back from it: the child ends\n"]);
    // SAFETY: the daemon's exit handlers must not run in the child.
    unsafe { libc::_exit(1) }
}

/// Ends the process: a constructor threw inside the dynamic linker, which no thread can use any
/// more.
pub(crate) fn constructor_threw(what: &str) -> ! {
    say("a C++ exception", " thrown by ");
    write(&["genomd: it says: ", what, "\n"]);
    end_is_ours();
    // SAFETY: exit would wait for the dynamic linker.
    unsafe { libc::_exit(1) }
}

/// Writes one line, using only what is allowed in signal handlers.
fn say(what: &str, by: &str) {
    match words() {
        "" => write(&["genomd: ", what, ", outside codels: the process ends\n"]),
        words => write(&["genomd: ", what, by, words, ": the process ends\n"]),
    }
}

fn write(parts: &[&str]) {
    let to = process::error_descriptor();
    for part in parts {
        // SAFETY: the bytes are those of a string.
        unsafe { libc::write(to, part.as_ptr().cast(), part.len()) };
    }
}
