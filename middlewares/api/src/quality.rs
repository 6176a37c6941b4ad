//! Quality of service of one end of a port, on middlewares that offer a choice.

use serde::{Deserialize, Serialize};

/// Quality of service of one end. `None` means the value from the middleware's section of the
/// configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Quality {
    /// Whether lost samples are sent again ("reliable") or not ("best effort").
    pub reliable: Option<bool>,
    /// How many samples of an out port may wait to be sent.
    pub depth: Option<usize>,
    /// Whether the middleware itself keeps samples for late readers (DDS "transient local").
    /// Foreign readers that request this durability connect only if it is set.
    pub transient_local: Option<bool>,
}
