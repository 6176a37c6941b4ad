//! What is remembered of types.

use genom_types::TypeId;

use crate::model::Span;

/// What tells two anonymous types apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    Basic(&'static str),
    String(Option<u32>),
    Array(TypeId, u32),
    Sequence(TypeId, Option<u32>),
    Optional(TypeId),
}

/// What is remembered of each type, by id.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Facts {
    /// Types on the way to the deepest one inside.
    pub(super) depth: u32,
    /// A native is inside.
    pub(super) native: bool,
    /// A type not complete when this was made is inside: look again.
    pub(super) open: bool,
    /// Began as a forward declaration.
    pub(super) forward: bool,
    /// Where it is declared; nothing for anonymous types.
    pub(super) span: Option<Span>,
}
