//! Files of shared libraries, read without loading them: no code of them runs.

#![forbid(unsafe_code)]

mod contents;
pub mod debug;
mod error;
pub mod languages;
mod read;
mod sections;

pub use contents::{Contents, Digest, is_script};
pub use error::OpenError;
pub use read::{EmbeddedDescription, Finishers, Segment, description_of, finishers};
pub use read::{mangled, needs, segments, uses_origin};
pub use sections::{Damage, NoSections, Sections};
