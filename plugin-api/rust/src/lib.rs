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
#[cfg(feature = "sources")]
pub mod sources;

pub use argument::{ByMut, ByRef, ByValue};
pub use component::Codel;
pub use context::{Context, ContextInterface};
pub use data::{
    Aggregate, Bool, BoundedSequence, BoundedString, Data, Enum, Enumeration, Native, NativeType,
    Optional, Sequence, Text,
};
pub use event::Event;
pub use exception::{Exception, Syserr, Thrown, Unkex};
/// A planner that a codel asks, and whose exception the codel ends with:
///
/// ```
/// use genom::{Context, Data, Event, Sequence, Thrown, event};
///
/// #[derive(Clone, Copy, Data)]
/// #[genom(name = "::planner::point")]
/// #[repr(C)]
/// struct Point {
///     x: f64,
///     y: f64,
/// }
///
/// genom::remote! {
///     /// Service `plan` of interface `planner`.
///     struct Plan(from: &Point, path: &mut Sequence<Point>);
/// }
///
/// #[genom::codel]
/// fn demo_ask(
///     from: &Point,
///     path: &mut Sequence<Point>,
///     plan: &mut Plan,
///     context: &Context,
/// ) -> Result<Event, Thrown> {
///     plan.call(from, path, context)?;
///     Ok(event!("::demo::follow"))
/// }
/// # fn main() {}
/// ```
///
pub use genom_derive::remote;
pub use genom_derive::{Data, Exception, NativeType, codel};
pub use outcome::Outcome;
pub use port::{InPort, MultipleInPort, MultipleOutPort, OutPort};

/// Used by the expansion of macros; not part of the interface.
#[doc(hidden)]
pub mod rt {
    pub use crate::component::{c_str, terminated};
    pub use crate::outcome::guard;
    pub use crate::remote::{Handle, call};
}
