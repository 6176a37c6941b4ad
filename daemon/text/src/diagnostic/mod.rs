//! Errors, warnings and hints about a description as data, the ways to show them, and the meaning of
//! each code.

mod fix;
mod human;
mod json;
mod list;
mod order;
mod register;

pub use fix::{Fix, fix};
pub use list::Diagnostics;
pub use order::{Rest, first, ordered};
pub use register::{Explanation, explain, explanations};

use crate::source::Span;

/// Ways to show diagnostics. All sort by position and omit repetitions.
pub mod render {
    pub use super::human::{human, short};
    pub use super::json::json;
}

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// The description is read, and something in it will not work as described.
    Hint,
    /// The description is read, but something in it is surprising.
    Warning,
    /// The description is refused.
    Error,
}

/// An error, warning or hint, with its positions in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable code such as `E0301` or `W0103`; of a hint the name of a property.
    pub code: &'static str,
    /// Whether the description is refused for it.
    pub severity: Severity,
    /// One sentence without final stop.
    pub message: String,
    /// Primary place.
    pub span: Span,
    /// Text under the primary position; may be empty.
    pub label: String,
    /// Other positions, each with its text ("declared here").
    pub notes: Vec<(Span, String)>,
    /// The way out, if one is known.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error at `span`.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Error, span, message.into())
    }

    /// A warning at `span`.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, span, message.into())
    }

    /// A hint at `span` about a property that does not hold.
    pub fn hint(property: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self::new(property, Severity::Hint, span, message.into())
    }

    fn new(code: &'static str, severity: Severity, span: Span, message: String) -> Self {
        Self { code, severity, message, span, label: String::new(), notes: Vec::new(), help: None }
    }

    /// Sets the text under the primary position.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Adds another position with its text.
    #[must_use]
    pub fn note(mut self, span: Span, text: impl Into<String>) -> Self {
        self.notes.push((span, text.into()));
        self
    }

    /// Sets the way out.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}
