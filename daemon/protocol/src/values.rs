//! Streams of a port's values.

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
    /// Name of the element, if the port is multiple.
    pub element: Option<String>,
    /// Maximum number of values per second.
    #[cfg_attr(feature = "openapi", param(exclusive_minimum = 0, maximum = 1000))]
    pub rate: Option<f64>,
    /// Encoding of the values: `json`, or `message` for CDR in base64, which is much faster for
    /// values with many numbers, such as images.
    #[cfg_attr(feature = "openapi", param(inline))]
    pub form: Option<Form>,
}

/// Encoding of the values of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Form {
    /// JSON, as everywhere in the control plane.
    #[default]
    Json,
    /// A CDR message, with its encapsulation header, in base64.
    Message,
}

/// Data of the event `end`, the last one of a stream of values.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StreamEnd {
    /// Why the stream ends.
    pub why: String,
}
