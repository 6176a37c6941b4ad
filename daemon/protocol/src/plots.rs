//! Plots: every sample of ports, in columns as they are drawn.

use serde::{Deserialize, Serialize};

/// `?columns=HERTZ&plot=PORT&plot=PORT/ELEMENT%23LEAF,LEAF`: pairs of names and values, since `plot`
/// may be there several times.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(transparent)]
pub struct PlotParameters(pub Vec<(String, String)>);

impl PlotParameters {
    /// Most plots of one stream.
    pub const MOST: usize = 64;
    /// Most numbers in one plot.
    pub const LEAVES: usize = 16;
    /// Greatest number of columns in a second.
    pub const FASTEST: f64 = 200.0;
    /// Columns in a second, unless the client says otherwise.
    pub const USUAL: f64 = 30.0;
}

/// Event `plots`, the first one: what is plotted.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Plots {
    /// In the order of the request.
    pub plots: Vec<Plot>,
    /// Width of a column, in nanoseconds.
    pub width_ns: u64,
}

/// A plot.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Plot {
    /// `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`.
    pub port: String,
    /// The numbers that it has, such as `position` or `ranges[17]`.
    pub leaves: Vec<String>,
    /// The first numbers that the values of the port have.
    pub known: Vec<String>,
}

/// Event `columns`: those that are complete since the event before.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PlotColumns {
    /// Plots with news.
    pub plots: Vec<ColumnsOfPlot>,
    /// Columns left out so far, because the client did not take them.
    pub skipped: u64,
}

/// Columns of one plot.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ColumnsOfPlot {
    /// Its place in [`Plots`].
    pub plot: usize,
    /// In order of date. A time in which there was no sample has no column.
    pub columns: Vec<Column>,
    /// Samples so far that are in no column, because they came faster than they could be taken.
    pub lost: u64,
}

/// All samples of a time as wide as a column.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Column {
    /// When it begins, in nanoseconds since 1970, or of the virtual clock; a multiple of the width.
    pub at: u64,
    /// Number of samples.
    pub samples: u32,
    /// Of each number: the first, the least, the greatest and the last. `null` if no sample had one
    /// that is finite.
    pub values: Vec<Option<[f64; 4]>>,
}

/// `?element=ID&width=PIXELS&seen=NUMBER`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct ImageParameters {
    /// Name of the element, if the port is multiple.
    pub element: Option<String>,
    /// Greatest width of the reply, in pixels; larger images are made smaller by whole factors.
    #[cfg_attr(feature = "openapi", param(minimum = 1, maximum = 4096))]
    pub width: Option<u32>,
    /// `image-sample` of the last reply: no image is sent until there is another one.
    pub seen: Option<u64>,
}
