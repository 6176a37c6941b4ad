//! Ports over shared memory, by iceoryx2.
//!
//! A port is the iceoryx2 publish-subscribe service `<instance>/<port>`. Types of fixed size
//! travel in their C layout under a stable type name ([`typing`]), so that a peer that only knows
//! iceoryx2 reads and writes them; others travel as CDR in a byte slice.
//!
//! Writing a value of fixed size costs one small allocation, which is iceoryx2's own (its handle
//! of a loaned sample); reading costs none.
//!
//! The `unsafe` code is `raw`, which is also all that uses iceoryx2's interface for types known
//! only at run time.

mod backend;
mod calls;
mod discover;
mod error;
mod options;
mod publisher;
mod queue;
mod raw;
mod subscription;
pub mod typing;
mod upkeep;

pub use backend::Shm;
pub use error::ShmError;
pub use options::Options;
