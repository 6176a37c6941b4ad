//! IDL types at run time: what they are, where their members lie, and their values.
//!
//! A [`TypeTable`] holds the types of one specification. A [`DataType`] is one of them, complete
//! and laid out as the platform's C compiler lays out the mapped type (genom3.md 5.2). A
//! [`Record`] is an owned value in that layout, with JSON and CDR in and out; [`foreign`] does
//! the same for values that others own.
//!
//! This crate knows no `.gen` text, no codel and no middleware. Its `unsafe` code is what
//! touches C memory: `memory`, `record`, `room`, `foreign`, `path` and the copying parts of `cdr`.

pub mod cdr;
mod data_type;
mod digest;
mod equality;
pub mod foreign;
mod graph;
mod ix;
pub mod json;
pub mod kind;
mod layout;
mod memory;
pub mod message;
mod names;
mod path;
mod record;
mod room;
pub mod table;

pub use cdr::{CdrError, CdrProblem};
pub use data_type::DataType;
pub use digest::{Digester, digest_of};
pub use json::{JsonError, JsonProblem};
pub use kind::{Kind, Label, Member, ScopedName, TypeId, UnionMember};
pub use layout::{Layout, LayoutError, MAX_NESTING, MAX_SIZE};
pub use path::{CompiledPath, PathError, PathStep};
pub use record::{BytesError, Record, TypeMismatch};
pub use room::{Room, Side, Zones};
pub use table::TypeTable;
