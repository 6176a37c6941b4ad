//! The state of a component between two of its codels, as files have it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::is_false;

/// The state of a component, between two of its codels.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrozenComponent {
    /// Its name in the description.
    pub component: String,
    /// Digest of the description.
    pub digest: String,
    /// The IDS; absent if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ids: Option<FrozenValue>,
    /// Last values of its ports, and of elements as `PORT/ELEMENT`; those without a value are left
    /// out.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ports: BTreeMap<String, FrozenValue>,
    /// Ports whose last value is not kept because it is large and nobody watched it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ports_left_out: Vec<String>,
    /// Services that were executed successfully, for `before` and `after` of others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub executed: Vec<String>,
    /// The states of the permanent activities that have not ended, by task.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tasks: BTreeMap<String, Vec<FrozenState>>,
    /// Activities of services; those of one task in the order in which it runs their codels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub activities: Vec<FrozenActivity>,
    /// Inputs of the attributes that were set, by service.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub attributes: BTreeMap<String, Value>,
    /// What a deployment called or started, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deployed: Vec<FrozenCall>,
}

/// A value, with the digest of its type.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrozenValue {
    /// Digest of the type. If that of the library is another one, members are taken over by name.
    pub digest: String,
    /// The value, as values are shown; what JSON cannot say is written in other forms.
    pub value: Value,
    /// What cannot be written: members of a `native` type.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

/// An activity of a service.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrozenActivity {
    /// Its number.
    #[cfg_attr(feature = "openapi", schema(value_type = u64))]
    pub id: u32,
    /// Its service.
    pub service: String,
    /// Whether it was started, or asked to stop.
    pub phase: FrozenPhase,
    /// It waits for the end of those that it interrupts.
    #[serde(default, skip_serializing_if = "is_false")]
    pub pending: bool,
    /// Who asked it to stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped_by: Option<String>,
    /// The states where it is; none before it was started.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<FrozenState>,
    /// Its inputs.
    pub inputs: FrozenValue,
    /// Its outputs so far.
    pub outputs: FrozenValue,
    /// Its local variables.
    pub locals: FrozenValue,
}

/// Phases of an activity's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum FrozenPhase {
    /// Accepted, not started.
    Init,
    /// Running.
    Run,
    /// In its `stop` state, or a later one.
    Stop,
}

/// A state where an activity is.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrozenState {
    /// Name of the state.
    pub state: String,
    /// What its codel waits for.
    pub waits: FrozenWait,
}

/// What the codel of a state waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum FrozenWait {
    /// Nothing: it runs next.
    Ready,
    /// The next tick, or an event in the component.
    Pause,
    /// An external event.
    Sleep,
}

/// A request of a deployment.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct FrozenCall {
    /// The service.
    pub service: String,
    /// Its inputs.
    pub inputs: Value,
}

/// The state with which a component is loaded: it goes on there.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Resumption {
    /// The state.
    pub state: FrozenComponent,
    /// Whether activities go on, too, and not only the IDS and the ports are put back.
    pub activities: bool,
    /// Whether its tasks wait until they are told to go on.
    #[serde(default, skip_serializing_if = "is_false")]
    pub hold: bool,
    /// What the state is, if the component is to be loaded without it when it does not fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub copy: Option<String>,
}

/// What is put back of a component when its process has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Restore {
    /// The IDS and the last values of ports.
    #[default]
    Ids,
    /// These, and activities in the states where they were.
    Activities,
}

impl Restore {
    /// Whether it is what is put back where nothing else is said.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
