//! Other daemons that this one sees, and sealed messages to them.

use serde::{Deserialize, Serialize};

use crate::is_false;

/// Daemons that are visible.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Daemons {
    /// Name of this one, where it is visible.
    pub own: Option<String>,
    /// All of them.
    pub daemons: Vec<VisibleDaemon>,
}

/// A daemon on a middleware.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct VisibleDaemon {
    /// What it calls itself; that is no proof.
    pub name: String,
    /// The middleware.
    pub backend: String,
}

/// What answered to a name.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Answers {
    /// Whoever answered in time.
    pub answers: Vec<Answered>,
}

/// One answer.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Answered {
    /// Which end of the middleware it came from.
    pub at: String,
    /// Its words.
    pub message: String,
}

/// `?at=ID&wait=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct AskParameters {
    /// Which end of the middleware is meant, as it was told with the answer to the hello.
    pub at: String,
    /// The answer may take an hour instead of a minute.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wait: bool,
}
