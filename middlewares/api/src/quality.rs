//! Quality of service of a single end of a port, on middlewares that leave a choice.

/// Quality of service of one end. What is `None` is as the section of the middleware in the
/// configuration says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Quality {
    /// Whether lost samples are sent again ("reliable") or not ("best effort").
    pub reliable: Option<bool>,
    /// Samples of an out port that may wait to be sent.
    pub depth: Option<usize>,
    /// Whether the middleware itself keeps samples for late readers (DDS: "transient local"), so
    /// that foreign readers that ask for this connect.
    pub transient_local: Option<bool>,
}
