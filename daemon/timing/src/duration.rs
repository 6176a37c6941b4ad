//! Times in words.

/// A time in nanoseconds, in milliseconds.
#[must_use]
pub fn duration(ns: u64) -> String {
    format!("{}.{:03} ms", ns / 1_000_000, ns / 1_000 % 1_000)
}
