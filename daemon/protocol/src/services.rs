//! Calls of services, and their replies.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{Activity, Outcome, is_false};

/// `?wait=true&zero=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct CallParameters {
    /// Reply only when the activity has ended.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wait: bool,
    /// Inputs left out take their defaults or zero, also those of an attribute.
    #[serde(default, skip_serializing_if = "is_false")]
    pub zero: bool,
}

/// Inputs of a service by name. No body at all means `{}`.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(transparent)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(value_type = Object))]
pub struct Inputs(pub Value);

/// Reply to a call.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(untagged)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum CallReply {
    /// The activity ended; only with `wait`.
    Activity(Activity),
    /// The activity was accepted and runs.
    Started(Started),
    /// The attribute or function ended.
    Ended(Outcome),
}

/// An activity was accepted.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Started {
    /// Its number.
    pub activity: u64,
}

impl CallReply {
    /// Number of the activity; `None` for an attribute or a function.
    #[must_use]
    pub fn activity(&self) -> Option<u64> {
        match self {
            Self::Activity(activity) => Some(activity.activity),
            Self::Started(started) => Some(started.activity),
            Self::Ended(_) => None,
        }
    }

    /// The outcome, if the service has ended.
    #[must_use]
    pub fn outcome(&self) -> Option<&Outcome> {
        match self {
            Self::Activity(Activity { outcome, .. }) | Self::Ended(outcome) => Some(outcome),
            Self::Started(_) => None,
        }
        .filter(|outcome| outcome.ended())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn each_answer_to_a_call_is_read_as_what_it_is() {
        for (reply, activity, ended) in [
            (json!({"result": {"x": 1}}), None, true),
            (json!({"exception": "::demo::E", "detail": null}), None, true),
            (json!({"activity": 3}), Some(3), false),
            (json!({"activity": 3, "service": "goto", "status": "running"}), Some(3), false),
            (
                json!({"activity": 3, "service": "goto", "status": "done", "result": {}}),
                Some(3),
                true,
            ),
        ] {
            let read: CallReply = serde_json::from_value(reply.clone()).unwrap();
            assert_eq!((read.activity(), read.outcome().is_some()), (activity, ended), "{reply}");
            assert_eq!(serde_json::to_value(read).unwrap(), reply);
        }
    }
}
