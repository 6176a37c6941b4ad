//! Why a step did not hold.

use genom_protocol::Outcome;
use serde_json::Value;

use super::daemon::Trouble;

/// A step that did not hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum Why {
    /// Something is not what it has to be.
    #[error("expected {expected}, came {came}")]
    Unmet { expected: String, came: String },
    /// The daemon did not do it.
    #[error(transparent)]
    Trouble(#[from] Trouble),
}

impl Why {
    pub(super) fn unmet(expected: impl Into<String>, came: impl Into<String>) -> Self {
        Self::Unmet { expected: expected.into(), came: came.into() }
    }
}

/// How a service ended, on one line.
pub(super) fn outcome(of: &Outcome) -> String {
    let full = |value: &Value| match value {
        Value::Null => None,
        Value::Object(members) if members.is_empty() => None,
        value => Some(value.to_string()),
    };
    match (&of.exception, &of.result) {
        (Some(name), _) => {
            let detail = of.detail.as_ref().and_then(full);
            detail.map_or_else(|| name.clone(), |detail| format!("{name} {detail}"))
        }
        (None, Some(result)) => {
            full(result).map_or_else(|| "done".to_owned(), |result| format!("done, {result}"))
        }
        (None, None) => "no end".to_owned(),
    }
}
