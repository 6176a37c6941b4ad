//! Why a component cannot be compiled into a plan.

use genom_types::LayoutError;

/// Why a component cannot be compiled into a plan.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The specification has no component with this index.
    #[error("there is no component number {component}: the specification has {known}")]
    NoComponent {
        /// The requested index.
        component: usize,
        /// Number of components.
        known: usize,
    },
    /// A type of a service or port has no layout.
    #[error("{what} of component {component} has no layout in memory")]
    Layout {
        /// The component.
        component: String,
        /// The service or port.
        what: String,
        /// The type, and the reason.
        #[source]
        source: LayoutError,
    },
    /// The model refers to something that does not exist.
    #[error("component {component} is inconsistent: {what}; report this description as a bug")]
    Inconsistent {
        /// The component.
        component: String,
        /// What does not exist.
        what: String,
    },
    /// More codels than a [`Machine`](super::Machine) can refer to.
    #[error("component {component} has {count} codels, more than 65536: split it")]
    TooManyCodels {
        /// The component.
        component: String,
        /// Number of its codels.
        count: usize,
    },
    /// More events than an [`EventId`](crate::body::EventId) counts.
    #[error("component {component} has {count} states and exceptions, more than 65535: split it")]
    TooManyEvents {
        /// The component.
        component: String,
        /// Number of its events.
        count: usize,
    },
}
