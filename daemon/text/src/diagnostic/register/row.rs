//! One row of the register.

/// The explanation of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The code, e.g. `E0206`.
    pub code: &'static str,
    /// The rule in a few words.
    pub title: &'static str,
    /// Row of the language reference; empty for rules of genomd's own.
    pub rule: &'static str,
    /// The reason for the rule, and what to do.
    pub text: &'static str,
    /// A description that causes this diagnostic.
    pub example: &'static str,
}

/// A row of the register.
pub(super) const fn row(
    code: &'static str,
    rule: &'static str,
    title: &'static str,
    text: &'static str,
    example: &'static str,
) -> Explanation {
    Explanation { code, title, rule, text, example }
}
