//! Messages between two processes of which each waits for the other: a program and the daemon that it
//! steps, that daemon and its cells. They go over a pair of sockets (`AF_UNIX`, `SOCK_SEQPACKET`), and
//! a file may come with one.
//!
//! A thread that sleeps is woken in some 5 us, longer than most steps take. [`End::receive`] therefore
//! looks for a message for [`AWAKE`] before it sleeps, where the last one came that soon: two processes
//! in lockstep find each other awake, and an end that hears little costs nothing.

#![forbid(unsafe_code)]

mod end;

pub use end::{AWAKE, End};
