//! The result of the last call of a codel.

use genom_runtime::body::EventId;
use serde_json::Value;

/// The result of the last call of a codel.
pub(super) enum Last {
    /// A state, success, or an exception without detail.
    Plain,
    /// An exception of the plan, with that many bytes of detail.
    Detailed(EventId, usize),
    /// An exception of the plan, with its detail as JSON.
    Told(Value),
    /// A string that is not an event of the plan; exceptions of the C run time have details all the
    /// same.
    Unknown(String, Option<Value>),
    /// The codel did not return: a C++ exception, or an argument without an address.
    Failed(String),
}
