//! At which lines a codel is that does not return. Another thread may not look at a Lua state that runs;
//! a signal to the thread that runs it may have it call a hook, as the manual of Lua allows.

use std::cell::Cell;
use std::ffi::c_int;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use mlua::ffi::{self, lua_Debug, lua_State};

use super::log::Log;

/// The signal: genomd and its libraries use none of the real-time ones.
fn signal() -> c_int {
    libc::SIGRTMIN() + 3
}

/// How long it is waited for the lines.
const PATIENCE: Duration = Duration::from_secs(2);

thread_local! {
    /// What runs in this thread.
    static RUNS: Cell<*mut lua_State> = const { Cell::new(ptr::null_mut()) };
    static THREAD: Cell<c_int> = const { Cell::new(0) };
}

/// Where the lines are written.
static LOG: OnceLock<Log> = OnceLock::new();

/// Whether they were, since they were asked for.
static TOLD: (Mutex<bool>, Condvar) = (Mutex::new(false), Condvar::new());
static ASKED: AtomicBool = AtomicBool::new(false);

/// A Lua state that this thread runs, until it is dropped.
#[derive(Debug)]
pub(crate) struct Running(*mut lua_State);

/// A Lua state, by its address.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateAt(usize);

impl StateAt {
    pub(crate) fn of(thread: &mlua::Thread) -> Self {
        Self(thread.state() as usize)
    }
}

impl Running {
    pub(crate) fn enter(state: StateAt) -> Self {
        Self(RUNS.replace(state.0 as *mut lua_State))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        RUNS.set(self.0);
    }
}

/// The number of this thread, which can be told the signal from then on.
pub(crate) fn thread() -> i32 {
    let known = THREAD.get();
    if known != 0 {
        return known;
    }
    // SAFETY: both take and return plain values; the set is a value of this function.
    let own = unsafe {
        let mut signals: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&raw mut signals);
        libc::sigaddset(&raw mut signals, signal());
        libc::pthread_sigmask(libc::SIG_UNBLOCK, &raw const signals, ptr::null_mut());
        libc::gettid()
    };
    THREAD.set(own);
    own
}

/// Has a thread that runs Lua tell its lines; waits until it has, or for some time.
pub(crate) fn tell_lines(thread: i32, log: Log) {
    // Each time: genomd takes handlers back that are not its own.
    handle();
    let _ = LOG.set(log);
    let (told, changed) = &TOLD;
    let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
    *told = false;
    ASKED.store(true, Ordering::SeqCst);
    // SAFETY: a thread of this process, or none; the signal is handled.
    unsafe { libc::syscall(libc::SYS_tgkill, libc::getpid(), thread, signal()) };
    let _ = changed.wait_timeout_while(told, PATIENCE, |told| !*told);
    ASKED.store(false, Ordering::SeqCst);
}

fn handle() {
    let handler: extern "C" fn(c_int) = interrupted;
    // SAFETY: the action is complete; its handler calls what is permitted there.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = handler as libc::sighandler_t;
        action.sa_flags = libc::SA_RESTART;
        libc::sigaction(signal(), &raw const action, ptr::null_mut());
    }
}

extern "C" fn interrupted(_: c_int) {
    let state = RUNS.get();
    if state.is_null() || !ASKED.load(Ordering::SeqCst) {
        return;
    }
    // SAFETY: this thread runs the state, and this function may be called in handlers of signals.
    unsafe { ffi::lua_sethook(state, Some(tell), ffi::LUA_MASKCOUNT, 1) };
}

unsafe extern "C-unwind" fn tell(state: *mut lua_State, _: *mut lua_Debug) {
    // SAFETY: Lua calls this as a hook of the state that runs, with room on its stack.
    let text = unsafe {
        ffi::lua_sethook(state, None, 0, 0);
        ffi::luaL_traceback(state, state, ptr::null(), 0);
        let mut size = 0;
        let text = ffi::lua_tolstring(state, -1, &raw mut size);
        let text = std::slice::from_raw_parts(text.cast::<u8>(), size);
        let text = String::from_utf8_lossy(text).into_owned();
        ffi::lua_pop(state, 1);
        text
    };
    // Not of a later codel in the same state.
    if let Some(log) = LOG.get().filter(|_| ASKED.load(Ordering::SeqCst)) {
        log.error(&format!("a codel has not returned, and is here:\n{text}"));
    }
    let (told, changed) = &TOLD;
    *told.lock().unwrap_or_else(PoisonError::into_inner) = true;
    changed.notify_all();
}
