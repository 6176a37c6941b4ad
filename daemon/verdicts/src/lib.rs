//! What `genomctl verify` and `genomctl schedule` say of components: texts and JSON of what
//! `genom_formal` finds.
//!
//! A [`Subject`] is the component. [`Told`] is what was found of it, with what was [`Measured`];
//! [`rules`] says which rules of supervision can be broken, [`sums`] and [`schedule`] how long cycles
//! may take,
//! and [`trace`] writes runs that were found, as recordings and scenarios.

#![forbid(unsafe_code)]

mod columns;
mod data;
mod found;
mod measured;
pub mod rules;
pub mod schedule;
mod subject;
pub mod sums;
mod text;
mod told;
pub mod trace;

pub use found::{Found, Ticks};
pub use measured::Measured;
pub use subject::{Subject, Unread};
pub use told::{Asked, Known, Told};
