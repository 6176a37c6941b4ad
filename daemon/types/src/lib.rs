//! IDL types at run time: their C layout, their values, and these as JSON and CDR.
//!
//! A [`TypeTable`] holds the types of one specification. A [`DataType`] is one of them, complete
//! and laid out as the platform's C compiler lays out the mapped type (genom3.md 5.2). A
//! [`Record`] is an owned value in that layout, with JSON and CDR in and out; [`foreign`] does
//! the same for values in memory that others own.
//!
//! ```
//! use std::sync::Arc;
//!
//! use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
//! use serde_json::json;
//!
//! // struct state { double position; sequence<long, 4> faults; };
//! let mut table = TypeTable::default();
//! let position = table.add(Kind::Double);
//! let long = table.add(Kind::Long);
//! let faults = table.add(Kind::Sequence { element: long, bound: Some(4) });
//! let state = table.add(Kind::Struct {
//!     name: ScopedName::new(["demo", "state"]),
//!     members: vec![
//!         Member { name: "position".into(), ty: position },
//!         Member { name: "faults".into(), ty: faults },
//!     ],
//! });
//! let state = DataType::new(&Arc::new(table), state)?;
//! assert_eq!((state.size(), state.align(), state.member_offset(1)), (32, 8, Some(8)));
//!
//! let mut sent = Record::new(&state);
//! sent.merge_json(&json!({"position": 0.5, "faults": [7]}))?;
//! let mut message = Vec::new();
//! sent.encode_message(&mut message)?;
//!
//! let mut received = Record::new(&state);
//! received.decode_message(&message)?;
//! assert_eq!(received.to_json(), json!({"position": 0.5, "faults": [7]}));
//!
//! let error = received.merge_json(&json!({"faults": {"4": 1}})).unwrap_err();
//! assert_eq!(error.path, "faults");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This crate knows no `.gen` text, no codel and no middleware. Its `unsafe` code is what
//! touches C memory: `memory`, `record`, `room`, `foreign`, `path` and the copying parts of `cdr`.

pub mod cdr;
pub mod convert;
mod data_type;
mod definition;
mod digest;
mod equality;
pub mod foreign;
mod graph;
mod inside;
mod ix;
pub mod json;
pub mod kind;
mod layout;
mod leaves;
mod memory;
pub mod message;
mod names;
pub mod native;
mod outline;
mod path;
mod record;
mod room;
pub mod table;

pub use cdr::{CdrError, CdrProblem};
pub use convert::Conversion;
pub use data_type::DataType;
pub use definition::{Definition, DefinitionError};
pub use digest::{Digester, digest_of};
pub use json::{Exact, JsonError, JsonProblem, Places};
pub use kind::{Kind, Label, Member, ScopedName, TypeId, UnionMember};
pub use layout::{Layout, LayoutError, MAX_NESTING, MAX_SIZE};
pub use leaves::{Leaf, LeafError};
pub use outline::Outline;
pub use path::{CompiledPath, PathError, PathStep};
pub use record::{BytesError, Record, TypeMismatch};
pub use room::{Room, Side, Zones};
pub use table::TypeTable;
