//! The checked model: what a description means, with every name resolved into an index.

mod codel;
mod component;
mod ix;
mod path;
mod service;

pub use codel::{Codel, CodelKind, CodelParameter, Owner, Source, Yield};
pub use component::{Component, Dialect, Interface, Node, Port, PortDirection, Remote, Sink, Task};
pub use ix::{CodelIx, Indexed, Ix, PortIx, RemoteIx, ServiceIx, StateIx, TaskIx};
pub use path::PathStep;
pub use service::{AttributeTarget, Default, Direction, Parameter, Service, ServiceKind};

use std::sync::Arc;

pub use genom_text::source::Span;
use genom_types::{ScopedName, TypeId, TypeTable};

/// Everything a set of input files declares.
#[derive(Clone, Debug, std::default::Default)]
pub struct Specification {
    /// Types of the whole specification, those of every scope.
    pub types: Arc<TypeTable>,
    /// Constants in order of declaration.
    pub constants: Vec<Constant>,
    /// Interfaces in order of declaration.
    pub interfaces: Vec<Interface>,
    /// Components in order of declaration.
    pub components: Vec<Component>,
    /// `#pragma masquerade TEMPLATE TYPE DATA`, in order.
    pub masquerades: Vec<Masquerade>,
    /// Equal for texts that differ only in blanks, comments, and how they are split into files:
    /// their models differ in nothing but places.
    pub fingerprint: u64,
}

/// A constant and its value.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Full name.
    pub name: ScopedName,
    /// Declared type.
    pub ty: TypeId,
    /// The value in the JSON encoding of genom3.md appendix A.
    pub value: serde_json::Value,
    /// Where it is declared.
    pub span: Span,
}

/// A type or service that a middleware represents as one of its own.
#[derive(Clone, Debug)]
pub struct Masquerade {
    /// The middleware, e.g. `ros2`.
    pub template: String,
    /// Full name of the type, or of the service: `::demo::goto`.
    pub name: ScopedName,
    /// The type, unless it is a service.
    pub ty: Option<TypeId>,
    /// The foreign type, e.g. `geometry_msgs/msg/Pose`.
    pub data: String,
    /// Where it is declared.
    pub span: Span,
}
