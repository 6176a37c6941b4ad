//! What the replaced functions of the C library (`stand_ins.cc`) call, and a reference that keeps
//! them in the program. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::hint::black_box;

use super::notes::{self, Act};
use super::{forked, keys, limits, standard};
use crate::running;

unsafe extern "C" {
    fn genom_host_stand_in();
}

/// Refers to the functions, so that the linker keeps them in the program.
pub(super) fn keep() {
    // SAFETY: only looks up functions of the C library.
    unsafe { genom_host_stand_in() };
    black_box::<[*const (); 11]>([
        limits::setrlimit as *const (),
        limits::setrlimit64 as *const (),
        limits::prlimit as *const (),
        limits::prlimit64 as *const (),
        standard::close as *const (),
        forked::open as *const (),
        forked::socket as *const (),
        forked::socketpair as *const (),
        forked::open64 as *const (),
        keys::pthread_key_create as *const (),
        keys::pthread_key_delete as *const (),
    ]);
}

#[unsafe(no_mangle)]
extern "C" fn genom_host_in_codel() -> bool {
    running::in_codel()
}

/// A codel sends a signal to its own process; the handler may run on another thread.
#[unsafe(no_mangle)]
extern "C" fn genom_host_signal_sent(signal: c_int, pid: c_int) {
    // SAFETY: it has no preconditions.
    if running::in_codel() && (pid == 0 || pid == unsafe { libc::getpid() }) {
        notes::add(Act::Sent, signal, 0, running::words());
    }
}
