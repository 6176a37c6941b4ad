//! IDL types at run time: what they are, where their members lie, and their values.
//!
//! A [`TypeTable`] holds the types of one specification. A [`DataType`] is one of them, complete
//! and laid out as the platform's C compiler lays out the mapped type (genom3.md 5.2). A
//! [`Record`] is an owned value in that layout, with JSON and CDR in and out.
//!
//! This crate knows no `.gen` text, no codel and no middleware. Its `unsafe` code is the view on
//! C memory in `record`; everything else is safe.

pub mod kind;
pub mod table;

pub use kind::{Kind, Label, Member, ScopedName, TypeId, UnionMember};
pub use table::TypeTable;
