//! Messages between two processes of which each waits for the other: a program and the daemon that it
//! steps, that daemon and its cells. They go over a pair of sockets (`AF_UNIX`, `SOCK_SEQPACKET`), and
//! a file may come with one.
//!
//! A thread that sleeps is woken in some 5 us, longer than most steps take. [`End::receive`] therefore
//! looks for a message for [`AWAKE`] before it sleeps, where the last one came that soon: two processes
//! in lockstep find each other awake, and an end that hears little costs nothing. While both are awake,
//! what is short goes through memory that both have, a [`Slate`], rather than as a message.

#![deny(unsafe_code)]

mod caller;
mod end;
mod sealed;
mod slate;

pub use caller::{Caller, DONE, NotDone, Reply, SLATE, TELL};
pub use end::{AWAKE, End, Heard};
pub use sealed::{checked, sealed};
pub use slate::{Answer, Asked, Slate};
