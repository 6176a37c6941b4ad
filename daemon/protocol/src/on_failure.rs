//! What is done of other components when a component fails, or breaks a rule of its supervision: the
//! way to the safe state of a robot.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::Address;
use crate::several::Item;

/// One thing to do then: exactly one of `call`, `start` and `fire`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reaction {
    /// A service to call, `component/service`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub call: Option<String>,
    /// An activity to start, `component/service`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// An external event to fire, `component/event`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fire: Option<String>,
    /// Inputs of the service by name; those left out take their defaults.
    #[serde(default = "no_inputs", skip_serializing_if = "is_empty")]
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub inputs: Value,
}

pub(crate) fn no_inputs() -> Value {
    Value::Object(Map::new())
}

pub(crate) fn is_empty(inputs: &Value) -> bool {
    inputs.as_object().is_some_and(Map::is_empty)
}

impl Default for Reaction {
    fn default() -> Self {
        Self { call: None, start: None, fire: None, inputs: no_inputs() }
    }
}

/// What a reaction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Calls a service.
    Call,
    /// Starts an activity.
    Start,
    /// Fires an event.
    Fire,
}

/// A reaction, taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deed {
    /// What it does.
    pub act: Act,
    /// Instance name of the component of which it does that.
    pub component: String,
    /// The service or event.
    pub name: String,
}

/// Why a reaction is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoReaction {
    /// None or several things to do.
    #[error(
        "a reaction takes one of `call`, `start` and `fire`: for several things write a list, such as \
         [[component.on_failure]] for each"
    )]
    Number,
    /// No address.
    #[error("`{0}` is no COMPONENT/NAME of a service or event")]
    Address(String),
    /// Inputs of an event.
    #[error("`fire` goes without `inputs`: events carry none")]
    Inputs,
}

impl Reaction {
    /// Takes it apart.
    ///
    /// # Errors
    /// It says nothing to do, several things, or no address.
    pub fn deed(&self) -> Result<Deed, NoReaction> {
        let all = [(Act::Call, &self.call), (Act::Start, &self.start), (Act::Fire, &self.fire)];
        let mut said = all.into_iter().filter_map(|(act, text)| Some((act, text.as_ref()?)));
        let (Some((act, text)), None) = (said.next(), said.next()) else {
            return Err(NoReaction::Number);
        };
        let address: Option<Address> = text.parse().ok();
        let address = address.filter(|address| address.element.is_none());
        let address = address.ok_or_else(|| NoReaction::Address(text.clone()))?;
        if act == Act::Fire && !is_empty(&self.inputs) {
            return Err(NoReaction::Inputs);
        }
        Ok(Deed { act, component: address.component, name: address.port })
    }
}

impl fmt::Display for Reaction {
    /// `call base/stop`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = [("call", &self.call), ("start", &self.start), ("fire", &self.fire)];
        let said = all.into_iter().find_map(|(act, text)| Some((act, text.as_ref()?)));
        said.map_or(Ok(()), |(act, text)| write!(f, "{act} {text}"))
    }
}

impl Item for Reaction {
    const EXPECTED: &str = "a table with `call`, `start` or `fire`, or a list of such tables";

    fn mistake(&self) -> Option<String> {
        self.deed().err().map(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::LoadRequest;

    fn read(on_failure: Value) -> Result<Vec<Reaction>, String> {
        let request = json!({"library": "arm", "on_failure": on_failure});
        let read: Result<LoadRequest, _> = serde_json::from_value(request);
        read.map(|request| request.on_failure).map_err(|error| error.to_string())
    }

    #[test]
    fn a_reaction_alone_and_a_list_of_them_are_read_and_a_list_is_written() {
        let stop = json!({"call": "base/stop", "inputs": {"hard": true}});
        let fire = json!({"fire": "base/emergency"});
        let alone = read(stop.clone()).unwrap();
        assert_eq!(alone[0].to_string(), "call base/stop");
        let both = read(json!([stop, fire])).unwrap();
        assert_eq!((both.len(), &both[0]), (2, &alone[0]));
        assert_eq!(serde_json::to_value(&both).unwrap(), json!([stop, fire]));
        let deed = Deed { act: Act::Fire, component: "base".into(), name: "emergency".into() };
        assert_eq!(both[1].deed(), Ok(deed));
    }

    #[test]
    fn what_does_nothing_or_two_things_or_names_nothing_is_refused() {
        for (wrong, why) in [
            (json!({}), "takes one of"),
            (json!({"call": "base/stop", "fire": "base/stop"}), "takes one of"),
            (json!({"call": "base"}), "`base` is no COMPONENT/NAME"),
            (json!({"start": "base/arm/left"}), "is no COMPONENT/NAME"),
            (json!({"fire": "base/emergency", "inputs": {"a": 1}}), "without `inputs`"),
            (json!({"cal": "base/stop"}), "unknown field `cal`"),
            (json!("base/stop"), "a table with `call`"),
            (json!([{"call": "base/stop"}, {}]), "takes one of"),
        ] {
            let refused = read(wrong.clone()).unwrap_err();
            assert!(refused.contains(why), "{wrong}: {refused}");
        }
    }
}
