//! The memory of a black box: what a process did last, for when it has crashed.
//!
//! A daemon makes a [`Memory`] for each process, itself included, and holds it open: what the
//! process wrote there is still there after `kill -9`. The process maps it ([`Writer`]) and has a
//! [`Track`] for each port and each kind of event. Tracks share a pool of blocks. Who needs one
//! takes the oldest of all, unless it holds its share already: then its own oldest. So all tracks
//! reach back equally far, and a loud one cannot push out the others.
//!
//! A daemon reads the memory with `pread` ([`read`]), whether the process lives or not: nothing is
//! locked, and nothing that stands there is believed. [`layout`] says what is where.

mod layout;
mod map;
mod memory;
mod plan;
mod read;
mod track;

pub use layout::{LEAST_BYTES, MOST_BYTES};
pub use memory::{Memory, MemoryError};
pub use read::{Filled, Kept, Record, filled, read};
pub use track::{NoRoom, Track, Writer};
