//! The daemon as a process of its machine: start, stop, signals, numbers.

mod lifecycle;
mod many;
mod numbers;
mod realtime;
mod signals;
