//! Other daemons that this one sees, and sealed messages to them.

use serde::{Deserialize, Serialize};

use crate::is_false;

/// Visible daemons.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Daemons {
    /// Name under which this daemon is visible to others, if it is.
    pub own: Option<String>,
    /// All visible daemons, this one included.
    pub daemons: Vec<VisibleDaemon>,
}

/// A daemon that is visible on a middleware.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct VisibleDaemon {
    /// The name it gives itself; not authenticated.
    pub name: String,
    /// Name of the middleware.
    pub backend: String,
}

/// Answers to a message sent to all daemons of a name.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Answers {
    /// Those that arrived in time.
    pub answers: Vec<Answered>,
}

/// One answer.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Answered {
    /// Identity of the endpoint on the middleware that sent it.
    pub at: String,
    /// The answer itself.
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
    /// Identity of the endpoint to ask, taken from its answer to the hello.
    pub at: String,
    /// Wait for the answer for up to an hour, instead of a minute.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wait: bool,
}
