//! Properties of types that checks need often.

use genom_types::TypeId;

use crate::model::Span;

/// Key by which anonymous types are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    Basic(&'static str),
    String(Option<u32>),
    Array(TypeId, u32),
    Sequence(TypeId, Option<u32>),
    Optional(TypeId),
}

/// Properties of a type, kept by its id.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Facts {
    /// Number of types on the path to the deepest one inside.
    pub(super) depth: u32,
    /// Contains a native.
    pub(super) native: bool,
    /// Contains a type that was incomplete when this was computed: compute again.
    pub(super) open: bool,
    /// Was first announced by a forward declaration.
    pub(super) forward: bool,
    /// Where it is declared; `None` for anonymous types.
    pub(super) span: Option<Span>,
}
