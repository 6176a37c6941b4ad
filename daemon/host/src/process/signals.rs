//! Signal actions of the process, restored when codels change them. One of the few unsafe modules.
//!
//! Signals that stop the daemon keep doing so. Signals whose default action would end the process,
//! such as a timer's, are recorded and have no effect. A signal that a library handles is left to
//! the library as long as it is loaded.
#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ops::Range;
use std::ptr;
use std::sync::OnceLock;

use super::limits;
use super::names::name;
use super::notes::{self, Act};
use crate::running;

/// Signals that the daemon depends on: to be stopped, and to survive writing to a closed
/// connection.
const OURS: [c_int; 4] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGPIPE];

/// Those of them that stop the daemon.
const STOPPING: [c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];

/// Signals whose default action ends the process, and which no supervisor sends; the real-time
/// signals belong to these too.
const HARMLESS: [c_int; 10] = [
    libc::SIGALRM,
    libc::SIGVTALRM,
    libc::SIGPROF,
    libc::SIGUSR1,
    libc::SIGUSR2,
    libc::SIGIO,
    libc::SIGPWR,
    libc::SIGSTKFLT,
    libc::SIGXCPU,
    libc::SIGXFSZ,
];

/// All signal numbers.
const ALL: Range<c_int> = 1..65;

/// The process's own actions by signal, recorded before codels could change them.
static OWN: OnceLock<Vec<Option<libc::sigaction>>> = OnceLock::new();

type Handler = extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void);

fn harmless() -> impl Iterator<Item = c_int> {
    // Whoever limits processor time wants the process ended.
    let ends = |signal: &c_int| *signal == libc::SIGXCPU && limits::of_time();
    let named = HARMLESS.iter().copied().filter(move |signal| !ends(signal));
    named.chain(libc::SIGRTMIN()..=libc::SIGRTMAX())
}

/// The recorded actions of the process.
#[derive(Debug)]
pub(super) struct KeptSignals(());

impl KeptSignals {
    /// Records the present actions; call it after the process has set them up. From then on,
    /// signals that would end the process needlessly are recorded instead.
    #[must_use]
    pub(super) fn remember() -> Self {
        OWN.get_or_init(|| {
            for signal in harmless() {
                make_harmless(signal);
            }
            let before = STOPPING.map(|signal| (signal, action(signal)));
            STOPS.get_or_init(|| before);
            STOPPING.iter().for_each(|signal| set(*signal, on_stop));
            ALL.map(action).collect()
        });
        Self(())
    }

    /// Restores actions that were changed; returns the names of these signals.
    pub(super) fn put_back(&self) -> Vec<String> {
        let ours = OURS.iter().copied().filter(|signal| {
            let same = own(*signal)
                .zip(action(*signal))
                .is_none_or(|(own, now)| own.sa_sigaction == now.sa_sigaction);
            !same && restore(*signal)
        });
        // A handler of a library is kept; the default action would end the process.
        let harmless = harmless().filter(|signal| {
            let default = action(*signal).is_some_and(|now| now.sa_sigaction == libc::SIG_DFL);
            default && restore(*signal)
        });
        ours.chain(harmless).map(name).collect()
    }
}

/// Restores the actions of signals that are handled by code in one of these ranges; returns the
/// names of these signals, and of those that could not be restored.
pub(crate) fn take_from(code: &[Range<usize>]) -> (Vec<String>, Vec<String>) {
    let is_there = |signal: &c_int| {
        let handler = action(*signal).map_or(0, |action| action.sa_sigaction);
        code.iter().any(|part| part.contains(&handler))
    };
    let (back, left): (Vec<_>, Vec<_>) = ALL.filter(is_there).partition(|signal| restore(*signal));
    (back.into_iter().map(name).collect(), left.into_iter().map(name).collect())
}

/// What raised a signal to stop from within the process, if something did.
#[must_use]
pub fn raised_to_stop() -> Option<String> {
    let notes = notes::take(&[Act::Sent]);
    let note = notes.into_iter().find(|note| STOPPING.contains(&note.number))?;
    let by = if note.words.is_empty() { "the process itself" } else { note.words.as_str() };
    Some(format!("{} raised by {by}", name(note.number)))
}

fn own(signal: c_int) -> Option<&'static libc::sigaction> {
    OWN.get()?.get(usize::try_from(signal - ALL.start).ok()?)?.as_ref()
}

fn restore(signal: c_int) -> bool {
    // SAFETY: an action that the system returned, whose handler is code of this program and not of
    // a library that may be closed.
    own(signal).is_some_and(|own| unsafe { libc::sigaction(signal, own, ptr::null_mut()) } == 0)
}

/// Sets a handler of this program.
fn set(signal: c_int, handler: Handler) {
    // SAFETY: all zeroes is an action: an empty mask, no flags.
    let mut action: libc::sigaction = unsafe { MaybeUninit::zeroed().assume_init() };
    action.sa_sigaction = handler as usize;
    action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_RESTART;
    // SAFETY: the handler has the signature for SA_SIGINFO, calls only functions that are allowed
    // in handlers, and is part of this program, which is never unloaded.
    unsafe { libc::sigaction(signal, &raw const action, ptr::null_mut()) };
}

fn make_harmless(signal: c_int) {
    if action(signal).is_some_and(|now| now.sa_sigaction == libc::SIG_DFL) {
        set(signal, on_harmless);
    }
}

/// Sender of a signal: a process id, or 0 for the kernel and its timers.
fn sender(info: *const libc::siginfo_t) -> i32 {
    // SAFETY: the system passes this for SA_SIGINFO; signals with these codes have a sender.
    unsafe {
        match (*info).si_code {
            libc::SI_USER | libc::SI_TKILL | libc::SI_QUEUE => (*info).si_pid(),
            _ => 0,
        }
    }
}

extern "C" fn on_harmless(signal: c_int, info: *mut libc::siginfo_t, _: *mut c_void) {
    let kept = Errno::keep();
    notes::add(Act::Signal, signal, sender(info), running::words());
    kept.put_back();
}

/// Previous actions of the signals that stop the daemon.
static STOPS: OnceLock<[(c_int, Option<libc::sigaction>); STOPPING.len()]> = OnceLock::new();

/// Records who raised the signal if it was this process, and calls the previous handler.
extern "C" fn on_stop(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    let kept = Errno::keep();
    // SAFETY: it has no preconditions.
    if sender(info) == unsafe { libc::getpid() } {
        notes::add(Act::Sent, signal, 0, running::words());
    }
    let before = STOPS.get().and_then(|all| all.iter().find(|(own, _)| *own == signal)?.1.as_ref());
    if let Some(before) =
        before.filter(|one| ![libc::SIG_DFL, libc::SIG_IGN].contains(&one.sa_sigaction))
    {
        // SAFETY: the handler that the process had set, with the signature that its flags say.
        unsafe {
            if before.sa_flags & libc::SA_SIGINFO != 0 {
                std::mem::transmute::<usize, Handler>(before.sa_sigaction)(signal, info, context);
            } else {
                std::mem::transmute::<usize, extern "C" fn(c_int)>(before.sa_sigaction)(signal);
            }
        }
    }
    kept.put_back();
}

/// Keeps the `errno` of the interrupted code.
struct Errno(c_int);

impl Errno {
    fn keep() -> Self {
        // SAFETY: errno belongs to this thread.
        Self(unsafe { *libc::__errno_location() })
    }

    fn put_back(self) {
        // SAFETY: as above.
        unsafe { *libc::__errno_location() = self.0 };
    }
}

/// The present action of a signal.
fn action(signal: c_int) -> Option<libc::sigaction> {
    let mut action = MaybeUninit::uninit();
    // SAFETY: without a new action, the system only writes the present one, to memory of its size.
    let told = unsafe { libc::sigaction(signal, ptr::null(), action.as_mut_ptr()) } == 0;
    // SAFETY: the system wrote it.
    told.then(|| unsafe { action.assume_init() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_somebody_changes_is_put_back_and_told_once() {
        // A background job of a shell ignores SIGINT from the start.
        // SAFETY: the default action calls no code.
        unsafe { libc::signal(libc::SIGINT, libc::SIG_DFL) };
        let kept = KeptSignals::remember();
        assert_eq!(kept.put_back(), Vec::<String>::new());
        let before = action(libc::SIGINT).map(|action| action.sa_sigaction);
        // SAFETY: ignoring a signal calls no code.
        unsafe { libc::signal(libc::SIGINT, libc::SIG_IGN) };
        assert_eq!(kept.put_back(), ["SIGINT"]);
        assert_eq!(kept.put_back(), Vec::<String>::new());
        assert_eq!(action(libc::SIGINT).map(|action| action.sa_sigaction), before);
        // A signal without handler does not end the process.
        // SAFETY: sends a signal to this process.
        unsafe { libc::raise(libc::SIGUSR1) };
        let notes = notes::take(&[Act::Signal]);
        assert_eq!((notes[0].number, notes[0].times), (libc::SIGUSR1, 1));
        // SAFETY: the default action calls no code.
        unsafe { libc::signal(libc::SIGUSR1, libc::SIG_DFL) };
        assert_eq!(kept.put_back(), ["SIGUSR1"]);
    }
}
