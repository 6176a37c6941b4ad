//! What the benchmarks of middlewares share: how they measure and print.
//!
//! The programs are under `benches`: `cargo bench -p genom-bench`.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "programs that measure end when something is wrong"
)]

pub mod octets;

pub use genom_floor::{Figures, FloorError, bare, clock, pair};

/// Sizes in bytes of the values in every benchmark.
pub const SIZES: [usize; 4] = [64, 4 << 10, 64 << 10, 1 << 20];
