//! The two ends of each middleware, without genomd: bytes are copied in by the writer and copied
//! out by the reader.

use std::path::Path;

use crate::error::FloorError;

mod ends;
mod place;
pub mod ros2;
pub mod shm;
pub mod zenoh;

pub use ends::Bare;

/// Opens a middleware by its name in genomd, in a folder that both processes share and nothing else
/// uses; `None` if there is no such middleware between processes.
///
/// # Errors
/// The middleware refuses.
pub fn open(name: &str, place: &Path, reads: bool) -> Result<Option<Box<dyn Bare>>, FloorError> {
    Ok(Some(match name {
        "shm" => Box::new(shm::Iceoryx::open(place)?),
        "zenoh" => Box::new(zenoh::Session::open(place, reads)?),
        "ros2" => Box::new(ros2::Participant::open(place)?),
        _ => return Ok(None),
    }))
}
