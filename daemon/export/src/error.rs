//! Why a model cannot be written.

use genom_formal::Limit;

/// Why a model cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The language counts in bytes.
    #[error("the component has {count} {what}, and a model in {format} may have {most}")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        most: usize,
        /// The language.
        format: &'static str,
    },
    /// Times are wanted.
    #[error("clocks want times of all codels")]
    NoTimes,
    /// Claims of Promela speak of what comes.
    #[error(
        "a formula about the past is checked by genomctl itself if it is `[]` of one, and of nothing \
         that comes"
    )]
    Past,
    /// The states are too many to be written out.
    #[error("the states cannot be written out: {0}; lower the bounds on clients")]
    Limit(Limit),
}
