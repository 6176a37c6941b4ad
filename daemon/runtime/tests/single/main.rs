//! Rules of tasks that share one thread (`Execution::Single`), and those of `tests/threads` that hold
//! for them as well.

#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod deadlines;
#[path = "../threads/hangs.rs"]
mod hangs;
mod held;
mod nested;
#[path = "../threads/order.rs"]
mod order;
mod sharing;
mod support;
#[path = "../threads/ticks.rs"]
mod ticks;
