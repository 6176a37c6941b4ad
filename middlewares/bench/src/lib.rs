//! What all benchmarks of middlewares measure and print alike.
//!
//! The programs are under `benches`: `cargo bench -p genom-bench`.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "programs that measure end when something is wrong"
)]

pub mod clock;
pub mod figures;
pub mod octets;
pub mod pair;

pub use figures::Figures;

/// The sizes of values that every benchmark shows.
pub const SIZES: [usize; 4] = [64, 4 << 10, 64 << 10, 1 << 20];
