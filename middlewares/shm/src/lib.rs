//! Ports over shared memory, by iceoryx2.
//!
//! A port is the iceoryx2 publish-subscribe service `<instance>/<port>`. Types of fixed size
//! travel in their C layout under a stable type name ([`typing`]), so that a peer that only knows
//! iceoryx2 reads and writes them; others travel as CDR in a byte slice.
//!
//! Writing costs one small allocation, which is iceoryx2's own: each loan of 0.10 makes a counted
//! handle on the heap, whatever the interface it is asked by, and its allocator cannot be chosen
//! yet (eclipse-iceoryx/iceoryx2#101). Reading costs none. Values of variable size are encoded in
//! the loan itself.
//!
//! **No zero-copy out ports.** `data()` of a port has one address for good, and still holds the
//! last value after `write` (genom3.md 7.8). Loaned memory belongs to the readers once it is sent:
//! the codel would have to go on in another loan, at another address, with the last value copied
//! into it. That is the very copy a loan would save.
//!
//! The `unsafe` code is `raw`, which is also all that uses iceoryx2's interface for types known
//! only at run time.

mod attain;
mod attributes;
mod backend;
mod calls;
mod catalog;
mod discover;
mod error;
mod ground;
mod heal;
mod inner;
mod limits;
mod options;
mod parked;
mod publisher;
mod queue;
mod raw;
mod rights;
mod room;
mod subscription;
pub mod typing;
mod upkeep;
mod watch;
mod writer;

pub use backend::Shm;
pub use error::ShmError;
pub use options::Options;
pub use rights::{default_prefix, default_root};
