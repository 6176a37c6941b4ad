//! Recordings that the daemon makes itself and keeps in a directory, with limits on how many there
//! are and how large they are together.

mod active;
mod base;
mod error;
mod glances;
mod name;
mod play;
mod replay;
mod store;
mod write;

pub use self::active::Active;
pub use self::error::KeptError;
pub use self::play::{Play, PlayError, Voice};
pub use self::store::Kept;
