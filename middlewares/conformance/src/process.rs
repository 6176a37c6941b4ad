//! What a process has of the system, for tests that count it.

use std::fs;

/// Descriptors and threads of this process.
#[must_use]
pub fn used() -> (usize, usize) {
    let count = |folder: &str| fs::read_dir(folder).expect("a folder of the system").count();
    (count("/proc/self/fd"), count("/proc/self/task"))
}

/// Resident memory of this process in kB.
#[must_use]
pub fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("a file of the system");
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("its memory");
    line.split_ascii_whitespace().nth(1).and_then(|kb| kb.parse().ok()).expect("a number")
}
