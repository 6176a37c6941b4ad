//! Why a script was not played to its end.

use genom_runtime::StartError;
use genom_types::LayoutError;

/// Why a script was not played to its end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NotPlayed {
    /// The component did not start.
    #[error("the component does not start: {0}")]
    Start(#[from] StartError),
    /// It asks for what the component does not have.
    #[error("step {step}: the component has no {what}")]
    NoSuch {
        /// Number of the step, from 0.
        step: usize,
        /// The kind of thing, and its name.
        what: String,
    },
    /// The component is not where the script says.
    #[error("step {step}, {at} ns: {why}")]
    Elsewhere {
        /// Number of the step, from 0.
        step: usize,
        /// The date.
        at: u64,
        /// What is expected, and what was found.
        why: String,
    },
    /// A service of the component has inputs without layout.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

impl NotPlayed {
    /// The step at which the run ended, if it began.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::NoSuch { step, .. } | Self::Elsewhere { step, .. } => Some(*step),
            Self::Start(_) | Self::Layout(_) => None,
        }
    }

    /// Whether the run did what the script does not say, or the other way round.
    #[must_use]
    pub fn is_elsewhere(&self) -> bool {
        matches!(self, Self::Elsewhere { .. })
    }
}
