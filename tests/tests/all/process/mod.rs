//! The daemon as a process: start, stop, signals, resources.

mod lifecycle;
mod many;
mod numbers;
mod realtime;
mod service_manager;
mod signals;
mod single;
