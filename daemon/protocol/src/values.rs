//! Values of a port as they come.

use serde::{Deserialize, Serialize};

/// `?rate=HERTZ&element=ID&form=FORM`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct StreamParameters {
    /// Element of a multiple port.
    pub element: Option<String>,
    /// Values a second, at most.
    #[cfg_attr(feature = "openapi", param(exclusive_minimum = 0, maximum = 1000))]
    pub rate: Option<f64>,
    /// How values are sent: `json`, or `message` for CDR in base64, which for many numbers, such
    /// as images, is written and read much faster.
    #[cfg_attr(feature = "openapi", param(inline))]
    pub form: Option<Form>,
}

/// How a stream sends values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Form {
    /// As the control plane does everywhere.
    #[default]
    Json,
    /// A CDR message, with its encapsulation header, in base64.
    Message,
}

/// Data of the event `end`, after which a stream of values has nothing more to say.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StreamEnd {
    /// Why it ends.
    pub why: String,
}
