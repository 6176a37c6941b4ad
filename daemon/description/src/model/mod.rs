//! The checked model: what a description means, with every name resolved into an index.

mod codel;
mod component;
mod service;

pub use codel::{Codel, CodelKind, CodelParameter, Owner, PathStep, Source, Yield};
pub use component::{Component, Dialect, Interface, Port, PortDirection, Remote, Sink, Task};
pub use service::{AttributeTarget, Default, Direction, Parameter, Service, ServiceKind};

use std::sync::Arc;

use genom_types::{ScopedName, TypeId, TypeTable};

/// A place in the source, resolved through the source map of its specification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Span {
    /// File, by its rank in the source map.
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// From the start of this place to the end of `last`, if both are in one file.
    #[must_use]
    pub fn to(self, last: Span) -> Span {
        if self.file == last.file && last.end >= self.start {
            Span { end: last.end.max(self.end), ..self }
        } else {
            self
        }
    }
}

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

/// A type or service that a middleware shall show as one of its own.
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
