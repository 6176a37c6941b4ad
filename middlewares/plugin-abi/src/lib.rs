//! The table between genomd and a middleware in a library of its own, as `genom3/middleware.h`
//! describes it: its structures ([`table`]), strings and bytes that cross ([`lent`]), and what
//! errors and answers of [`genom_middleware`] are there ([`codes`], [`answers`]).
//!
//! `genom-plugin-host` is the side of genomd, `genom-plugin` that of a plugin in Rust.

pub mod answers;
pub mod codes;
pub mod lent;
pub mod table;

pub use codes::{Code, Failure, Sides};
pub use lent::{Bytes, ErrorText, Str};
pub use table::{Address, Answer, Diagnosis, Entry, Host, Pair, Plugin, Port, Service, Type};

/// A host refuses plugins of another one.
pub const MAJOR: u16 = 1;

/// Grows when something is added at an end.
pub const MINOR: u16 = 2;

/// What the library exports.
pub const SYMBOL: &str = "genom_middleware_plugin";
