//! The floor of a middleware: what a value costs from one process to another with the middleware's
//! own library and nothing else, so that what ports of genomd add can be told.
//!
//! [`bare`] has the two ends on each middleware, [`pair`] the two processes, and [`asked`] is what
//! `genomctl bench` starts: `genomd --floor ...`.

#![forbid(unsafe_code)]

pub mod bare;
pub mod clock;
mod command;
mod error;
pub mod figures;
pub mod pair;

pub use command::asked;
pub use error::FloorError;
pub use figures::Figures;
