//! Ports and services over shared memory, using iceoryx2.
//!
//! A port is the iceoryx2 publish-subscribe service `<instance>/<port>`. Types of fixed size are
//! sent in their C layout under a stable type name ([`typing`]), so that programs that use only
//! iceoryx2 can read and write them; other types are sent as CDR in a byte slice.
//!
//! Writing makes one small allocation, inside iceoryx2: each loan of 0.10 allocates a
//! reference-counted handle, through every interface, and its allocator cannot be chosen yet
//! (eclipse-iceoryx/iceoryx2#101). Reading allocates nothing. Values of variable size are encoded
//! directly into the loaned sample.
//!
//! **No zero-copy out ports.** `data()` of a port always has the same address, and still holds the
//! last value after `write` (genom3.md 7.8). Loaned memory belongs to the readers once it is sent,
//! so the codel would have to continue in another loan, at another address, with the last value
//! copied into it: the very copy that a loan should save.
//!
//! The `unsafe` code is in `raw`, the only module that uses iceoryx2's interface for types known
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
