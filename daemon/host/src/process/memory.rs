//! Memory that work on large inputs took and gave back. One of the few unsafe modules.
//!
//! The C library keeps freed memory for the thread pool's next work, by thread: a daemon that read
//! a few huge descriptions on different threads would keep as much as each of them took.
#![allow(unsafe_code)]

/// Growth from which on memory is given back to the system, in bytes: below, it is kept for what
/// comes next.
const MUCH: u64 = 32 << 20;

/// Does some work and gives back to the system the memory that it took and freed, if it was much.
/// Not for real-time threads: it takes the allocator's locks.
pub fn without_leftovers<T>(work: impl FnOnce() -> T) -> T {
    let before = resident();
    let done = work();
    if resident().saturating_sub(before) > MUCH {
        give_back();
    }
    done
}

/// Memory of the process in RAM, in bytes; 0 when the system does not tell.
fn resident() -> u64 {
    // proc(5): `VmRSS:     1234 kB`.
    let told = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = told.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    number.unwrap_or(0) << 10
}

#[cfg(target_env = "gnu")]
fn give_back() {
    // SAFETY: it takes a number, and touches only what is free.
    let _ = unsafe { libc::malloc_trim(0) };
}

/// Other C libraries give back by themselves.
#[cfg(not(target_env = "gnu"))]
fn give_back() {}
