//! Why a component cannot be planned.

use genom_types::LayoutError;

/// Why a component cannot be planned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The specification has no such component.
    #[error("there is no component number {component}: the specification has {known}")]
    NoComponent {
        /// What was asked for.
        component: usize,
        /// How many there are.
        known: usize,
    },
    /// A type of a service or port has no layout.
    #[error("{what} of component {component} has no layout in memory")]
    Layout {
        /// Component that has it.
        component: String,
        /// What has this type.
        what: String,
        /// Which type, and why.
        #[source]
        source: LayoutError,
    },
    /// The model refers to something that is not there.
    #[error("component {component} is inconsistent: {what}; report this description as a bug")]
    Inconsistent {
        /// Component that is wrong.
        component: String,
        /// What is missing.
        what: String,
    },
    /// More events than an [`EventId`](crate::body::EventId) counts.
    #[error("component {component} has {count} states and exceptions, more than 65535: split it")]
    TooManyEvents {
        /// Component that has too many.
        component: String,
        /// How many.
        count: usize,
    },
}
