//! Macros as they are stored.

use std::cell::Cell;

use crate::ptoken::PToken;
use crate::source::Span;

/// A macro.
#[derive(Debug)]
pub(super) struct Macro {
    pub(super) name: Box<str>,
    pub(super) shape: Shape,
    pub(super) body: Vec<Item>,
    pub(super) span: Span,
    /// Its expansion is being read: the name is not expanded again (C99 6.10.3.4).
    pub(super) busy: Cell<bool>,
}

/// How a macro is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Object,
    Function {
        parameters: usize,
        /// The last parameter takes all remaining arguments.
        variadic: bool,
    },
    /// `__FILE__`.
    File,
    /// `__LINE__`.
    Line,
}

/// A token of a macro's body, with what is to be done with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) token: PToken,
    pub(super) role: Role,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Plain,
    /// The parameter at this rank.
    Parameter(usize),
    /// `#` before the parameter at this rank.
    Stringize(usize),
    /// `##` between two other tokens.
    Paste,
}
