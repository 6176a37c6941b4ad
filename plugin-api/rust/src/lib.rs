//! What the author of a component in Rust links.
//!
//! Codels are plain safe functions marked [`codel`], data types are `#[repr(C)]` structs that
//! derive [`Data`], and [`component!`] makes of them a library that genomd loads and checks
//! against its `.gen` file before it calls anything:
//!
//! ```
//! use genom::{Context, Data, Event, Exception, OutPort, Thrown, event};
//!
//! #[derive(Clone, Copy, Data)]
//! #[genom(name = "::tank::level")]
//! #[repr(C)]
//! struct Level {
//!     height: f64,
//! }
//!
//! #[derive(Clone, Copy, Exception)]
//! #[genom(name = "::tank::OVERFLOW")]
//! #[repr(C)]
//! struct Overflow {
//!     height: f64,
//! }
//!
//! #[genom::codel]
//! fn tank_fill(
//!     rate: f64,
//!     current: &mut Level,
//!     level: &mut OutPort<Level>,
//!     context: &Context,
//! ) -> Result<Event, Thrown> {
//!     current.height += rate;
//!     if current.height > 1.0 {
//!         return Err(Overflow { height: current.height }.raise(context));
//!     }
//!     level.publish(*current, context)?;
//!     Ok(event!("::tank::pause::main"))
//! }
//! # fn main() {}
//! ```
//!
//! The table that the library exports is in [`abi`]. Unions have no mapping yet.

pub mod abi;
mod argument;
mod component;
mod context;
pub mod data;
mod event;
mod exception;
mod memory;
mod outcome;
mod port;
mod remote;

pub use argument::{ByMut, ByRef, ByValue};
pub use component::Codel;
pub use context::{Context, ContextInterface};
pub use data::{
    Aggregate, Bool, BoundedSequence, BoundedString, Data, Enum, Enumeration, Native, NativeType,
    Optional, Sequence, Text,
};
pub use event::Event;
pub use exception::{Exception, Syserr, Thrown, Unkex};
pub use genom_derive::{Data, Exception, NativeType, codel, remote};
pub use outcome::Outcome;
pub use port::{InPort, MultipleInPort, MultipleOutPort, OutPort};

/// What the macros expand to; no part of the interface.
#[doc(hidden)]
pub mod rt {
    pub use crate::component::{c_str, terminated};
    pub use crate::outcome::guard;
    pub use crate::remote::{Handle, call};
}
