//! Builds a component: with its own build files if it has some, else all codels beside the
//! description.

mod bare;
mod compile;
mod error;
mod explain;
mod headers;
mod kind;
mod packages;

pub use bare::{Bare, Built};
pub use error::BuildError;
pub use kind::{Kind, description, kind};

/// What is told while building, one line at a time.
pub type Tell<'t> = &'t mut dyn FnMut(&str);
