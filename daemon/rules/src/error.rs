//! Why rules do not fit their component.

use genom_runtime::NoProgram;

/// Why a rule does not fit its component. `at` is its place in the list.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum NoSuchRule {
    /// A name.
    #[error("{rule}: {component} has no {what} `{typed}`; {help}")]
    NoSuch {
        at: usize,
        rule: String,
        component: String,
        what: &'static str,
        typed: String,
        help: String,
    },
    /// A name in a text.
    #[error("{rule}: column {column}: {why}")]
    Name { at: usize, rule: String, column: usize, why: String },
    /// What is asked makes no sense here.
    #[error("{rule}: {why}")]
    Idle { at: usize, rule: String, why: String },
    /// A formula that cannot be judged as it happens.
    #[error("{rule}: {source}")]
    Program { at: usize, rule: String, source: NoProgram },
}

impl NoSuchRule {
    /// The place of the rule in the list.
    #[must_use]
    pub fn at(&self) -> usize {
        match self {
            Self::NoSuch { at, .. }
            | Self::Name { at, .. }
            | Self::Idle { at, .. }
            | Self::Program { at, .. } => *at,
        }
    }
}
