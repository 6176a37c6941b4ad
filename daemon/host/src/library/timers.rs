//! Timers of the process that call a function in a thread (`SIGEV_THREAD`).
//!
//! The C library implements them with an internal signal to an internal thread, and the address of
//! its own record of the timer as the value. The record contains the function; where that is not
//! found, the timer counts as one that may call anything.

use std::fs::{self, File};
use std::ops::Range;
use std::os::unix::fs::FileExt as _;

use super::threads;

/// The internal signal for such timers (`SIGTIMER` in glibc).
const DUE: &str = "32";
/// Most words of a timer's record that are searched.
const NOTE: usize = 16;

/// Number of timers that call code in one of these ranges, or may.
pub(super) fn into(code: &[Range<usize>]) -> usize {
    let told = fs::read_to_string("/proc/self/timers").unwrap_or_default();
    let notes: Vec<usize> = notes(&told).collect();
    if notes.is_empty() {
        return 0;
    }
    let mapped = threads::executable();
    let Ok(memory) = File::open("/proc/self/mem") else { return notes.len() };
    let calls = |note: &&usize| {
        let mut bytes = [0; NOTE * size_of::<usize>()];
        let read = memory.read_at(&mut bytes, **note as u64).unwrap_or(0);
        let words = bytes[..read].chunks_exact(size_of::<usize>());
        let functions: Vec<usize> = words
            .filter_map(|word| word.try_into().ok().map(usize::from_ne_bytes))
            .filter(|at| mapped.iter().any(|part| part.contains(at)))
            .collect();
        functions.is_empty() || functions.iter().any(|at| code.iter().any(|own| own.contains(at)))
    };
    notes.iter().filter(calls).count()
}

/// Addresses of the C library's timer records.
fn notes(told: &str) -> impl Iterator<Item = usize> {
    // signal: NUMBER/VALUE
    let signals = told.lines().filter_map(|line| line.strip_prefix("signal: ")?.split_once('/'));
    let due = signals.filter(|(number, _)| *number == DUE);
    due.filter_map(|(_, value)| usize::from_str_radix(value.trim_start_matches("0x"), 16).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_list_of_timers_is_read() {
        let told = "ID: 0\nsignal: 14/0000000000000000\nnotify: signal/pid.12\nClockID: 1\n\
                    ID: 1\nsignal: 32/00007f3a04000b70\nnotify: signal/tid.14\nClockID: 1\n";
        assert_eq!(notes(told).collect::<Vec<_>>(), [0x7f3a_0400_0b70]);
        assert_eq!(notes("").count(), 0);
    }
}
