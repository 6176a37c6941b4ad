//! Returns memory to the system after work on large inputs. One of the few unsafe modules.
//!
//! The C library keeps freed memory in arenas, which belong to threads: a daemon that read a few
//! huge descriptions on different threads would keep the memory of each.
#![allow(unsafe_code)]

/// Growth in bytes above which memory is returned to the system; less is kept for later work.
const MUCH: u64 = 32 << 20;

/// Runs `work`, and returns to the system the memory that it allocated and freed, if that is much.
/// Not for real-time threads, since it takes the locks of the allocator.
pub fn without_leftovers<T>(work: impl FnOnce() -> T) -> T {
    let before = resident();
    let done = work();
    if resident().saturating_sub(before) > MUCH {
        give_back();
    }
    done
}

/// Resident memory of the process in bytes; 0 if unknown.
fn resident() -> u64 {
    // proc(5): `VmRSS:     1234 kB`.
    let told = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = told.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    number.unwrap_or(0) << 10
}

#[cfg(target_env = "gnu")]
fn give_back() {
    // SAFETY: takes a number, and changes free memory only.
    let _ = unsafe { libc::malloc_trim(0) };
}

/// Other C libraries return freed memory by themselves.
#[cfg(not(target_env = "gnu"))]
fn give_back() {}
