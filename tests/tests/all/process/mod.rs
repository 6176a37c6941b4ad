//! The daemon as a process: start, stop, signals, resources.

mod lifecycle;
mod many;
mod numbers;
mod realtime;
mod signals;
