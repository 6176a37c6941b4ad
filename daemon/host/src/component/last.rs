//! What a call of a codel ended with.

use genom_runtime::body::EventId;
use serde_json::Value;

/// What the last call ended with.
pub(super) enum Last {
    /// A state, success, or an exception without detail.
    Plain,
    /// An exception of the plan, with that many bytes of detail.
    Detailed(EventId, usize),
    /// An exception of the plan, with its detail.
    Told(Value),
    /// Something the plan does not know; exceptions of the C run time have details all the same.
    Unknown(String, Option<Value>),
    /// No codel returned: a C++ exception, or an argument without a place.
    Failed(String),
}
