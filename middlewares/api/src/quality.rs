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
