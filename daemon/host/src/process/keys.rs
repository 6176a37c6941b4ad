//! Destructors of thread-specific data, which run when threads end, also those of the daemon. One
//! of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// `PTHREAD_KEYS_MAX`.
const MOST: usize = 1024;

/// Destructor of each key; 0 for none.
static DESTRUCTORS: [AtomicUsize; MOST] = [const { AtomicUsize::new(0) }; MOST];

type Destructor = Option<unsafe extern "C" fn(*mut c_void)>;
type Create = unsafe extern "C" fn(*mut u32, Destructor) -> c_int;
type Delete = unsafe extern "C" fn(u32) -> c_int;

/// Whether a destructor in one of these ranges would run at the end of a thread.
pub(crate) fn ends_threads(code: &[Range<usize>]) -> bool {
    let all = DESTRUCTORS.iter().map(|one| one.load(Ordering::Acquire));
    all.filter(|at| *at != 0).any(|at| code.iter().any(|part| part.contains(&at)))
}

fn note(key: u32, destructor: usize) {
    if let Some(slot) = usize::try_from(key).ok().and_then(|key| DESTRUCTORS.get(key)) {
        slot.store(destructor, Ordering::Release);
    }
}

/// The C library's function with this name.
fn next(known: &AtomicUsize, name: &std::ffi::CStr) -> usize {
    let mut found = known.load(Ordering::Relaxed);
    if found == 0 {
        // SAFETY: only looks up a name.
        found = unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) } as usize;
        known.store(found, Ordering::Relaxed);
    }
    found
}

/// The C library's `pthread_key_create`, except that the destructor is recorded.
///
/// # Safety
/// As for the C library's.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn pthread_key_create(key: *mut u32, with: Destructor) -> c_int {
    static REAL: AtomicUsize = AtomicUsize::new(0);
    let real = next(&REAL, c"pthread_key_create");
    // SAFETY: the C library's function has this type; the arguments are the caller's.
    unsafe {
        let error = std::mem::transmute::<usize, Create>(real)(key, with);
        if error == 0 {
            note(*key, with.map_or(0, |with| with as usize));
        }
        error
    }
}

/// The C library's `pthread_key_delete`, except that the record is removed.
///
/// # Safety
/// As for the C library's.
#[unsafe(no_mangle)]
pub(super) unsafe extern "C" fn pthread_key_delete(key: u32) -> c_int {
    static REAL: AtomicUsize = AtomicUsize::new(0);
    let real = next(&REAL, c"pthread_key_delete");
    note(key, 0);
    // SAFETY: the C library's function has this type; the argument is the caller's.
    unsafe { std::mem::transmute::<usize, Delete>(real)(key) }
}
