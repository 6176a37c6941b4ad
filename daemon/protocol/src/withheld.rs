//! Signs of life that the service manager does not get since a component broke a rule of its
//! supervision whose reaction is `withhold`.

use serde::{Deserialize, Serialize};

/// Why the service manager gets no sign of life; empty if it gets them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Withheld {
    /// Components that broke such a rule, by name.
    pub withheld: Vec<WithheldFor>,
}

/// A component that broke such a rule.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct WithheldFor {
    /// Its instance name.
    pub component: String,
    /// The rule, and what broke it.
    pub why: String,
}

/// Signs of life are not withheld any more because of a component.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Cleared {
    /// Why they were; absent if they were not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub was: Option<String>,
}
