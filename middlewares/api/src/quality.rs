//! What may be asked of a single end of a port, on middlewares that leave a choice.

/// Quality of service of one end; what is not said is as the middleware is configured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Quality {
    /// Lost samples are sent again; otherwise they are lost ("best effort").
    pub reliable: Option<bool>,
    /// Samples of an out port that may wait to be sent.
    pub depth: Option<usize>,
    /// Late readers are served in the middleware's own way, so that foreign ones may count on it.
    pub transient_local: Option<bool>,
}

/// Why an end and another one do not meet, though both are there, or do not get from each other what
/// they could.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Obstacle {
    /// What is in the way, as a sentence without a stop.
    pub what: String,
    /// What to do.
    pub fix: String,
}
