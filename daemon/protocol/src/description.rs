//! What a component offers, as its description says it.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::Display;

use crate::{Component, PortDirection};

/// A component that runs, with all its description says.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Description {
    /// What is this instance's own.
    #[serde(flatten)]
    pub instance: Component,
    /// `2010` or `2011`, the languages of two papers, or `current`.
    #[serde(default)]
    pub dialect: String,
    /// Documentation.
    pub doc: Option<String>,
    /// Version of the component.
    pub version: String,
    /// `c`, `c++` or `rust`: the language of its codels.
    #[serde(default)]
    pub lang: String,
    /// Who to write to.
    pub email: Option<String>,
    /// Packages that its users need.
    #[serde(default)]
    pub requires: Vec<String>,
    /// Packages that its codels need.
    #[serde(default)]
    pub codels_requires: Vec<String>,
    /// Period of the clock of its tasks, in seconds.
    pub clock_rate: Option<f64>,
    /// Its internal data.
    pub ids: Option<Vec<Member>>,
    /// Execution tasks.
    pub tasks: Vec<TaskDescription>,
    /// Ports.
    pub ports: Vec<PortDescription>,
    /// Services of others that its codels call.
    #[serde(default)]
    pub uses: Vec<RemoteDescription>,
    /// Services, those that every component has among them.
    pub services: Vec<Service>,
    /// States of its codels.
    #[serde(default)]
    pub states: Vec<String>,
    /// Events that can be fired from outside.
    #[serde(default)]
    pub events: Vec<String>,
    /// Exceptions of its codels.
    #[serde(default)]
    pub throws: Vec<String>,
    /// Digest of all this: equal for two components of one interface.
    #[serde(default)]
    pub digest: String,
}

/// A member of the internal data.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Member {
    /// The member.
    pub name: String,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
}

/// An execution task. Times are in seconds.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskDescription {
    /// The task.
    pub name: String,
    /// Documentation.
    pub doc: Option<String>,
    /// Its period; none of an aperiodic one.
    pub period: Option<f64>,
    /// From the date of a period to its tick.
    #[serde(default)]
    pub delay: f64,
    /// 0, the highest, to 255.
    pub priority: Option<u32>,
    /// Whether it asks for real-time scheduling.
    #[serde(default)]
    pub real_time: bool,
    /// Bytes of its stack.
    pub stack: Option<u64>,
    /// Codels of its permanent activity.
    #[serde(default)]
    pub codels: Vec<Codel>,
    /// Exceptions of these.
    #[serde(default)]
    pub throws: Vec<String>,
}

/// A port.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortDescription {
    /// The port.
    pub name: String,
    /// Whether the component reads or writes it.
    pub direction: PortDirection,
    /// Whether it has elements.
    pub multiple: bool,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Documentation.
    pub doc: Option<String>,
}

/// A service of another component that codels call.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RemoteDescription {
    /// The remote.
    pub name: String,
    /// The interface that has the service.
    pub interface: String,
    /// What the service takes and gives.
    pub parameters: Vec<Parameter>,
    /// Exceptions it may end with.
    #[serde(default)]
    pub throws: Vec<String>,
    /// [`Service::call_digest`] of the services that can be connected to it.
    #[serde(default)]
    pub digest: String,
}

/// A service: an attribute, a function or an activity.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Service {
    /// The service.
    pub name: String,
    /// What kind of service it is.
    pub kind: ServiceKind,
    /// Whether every component has it.
    #[serde(default)]
    pub standard: bool,
    /// Documentation.
    pub doc: Option<String>,
    /// What it takes and gives.
    pub parameters: Vec<Parameter>,
    /// Variables of its codels.
    #[serde(default)]
    pub locals: Vec<Parameter>,
    /// The task that runs it; none of attributes and functions.
    pub task: Option<String>,
    /// Services that it interrupts.
    #[serde(default)]
    pub interrupts: Vec<String>,
    /// Services that it comes before.
    #[serde(default)]
    pub before: Vec<String>,
    /// Services that it comes after.
    #[serde(default)]
    pub after: Vec<String>,
    /// Codels that look at its inputs before it runs.
    #[serde(default)]
    pub validates: Vec<Codel>,
    /// Its codels.
    #[serde(default)]
    pub codels: Vec<Codel>,
    /// Exceptions it may end with.
    #[serde(default)]
    pub throws: Vec<String>,
    /// Digest of its whole description.
    #[serde(default)]
    pub digest: String,
    /// Digest of what a caller sees of it.
    #[serde(default)]
    pub call_digest: String,
    /// Middlewares that it is offered on (`[services]` of the daemon's configuration).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub served: Option<Vec<String>>,
    /// JSON Schema of its inputs; of a service that was asked for by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_schema: Option<Value>,
    /// JSON Schema of its outputs; as there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_schema: Option<Value>,
}

/// Kind of a service.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum ServiceKind {
    /// Reads or sets internal data; replies at once.
    Attribute,
    /// A computation; replies at once.
    Function,
    /// Runs for a while: accepted, then states, then a result; can be aborted.
    Activity,
}

/// What a service takes or gives under a name.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Parameter {
    /// The name.
    pub name: String,
    /// Whether it is taken or given.
    pub direction: Direction,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Taken when the input is left out, but of an attribute.
    pub default: Option<Value>,
    /// Documentation.
    pub doc: Option<String>,
    /// Of an input of an attribute that was asked for by name: what it keeps when it is left out,
    /// for those who may call it, and unless codels are in the way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current: Option<Value>,
}

/// Whether a parameter is taken or given.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Direction {
    /// Taken.
    In,
    /// Given.
    Out,
    /// Both.
    InOut,
}

impl Direction {
    /// Whether it is taken.
    #[must_use]
    pub fn is_input(self) -> bool {
        self != Self::Out
    }
}

/// A codel.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Codel {
    /// The codel.
    pub name: String,
    /// Whether it runs in a thread of its own.
    #[serde(rename = "async")]
    pub asynchronous: bool,
    /// States that it runs in; of a state machine.
    pub on: Option<Vec<String>>,
    /// States that it yields, `pause::` before those that wait for the next tick or event.
    pub yields: Option<Vec<String>>,
    /// Its arguments.
    pub parameters: Vec<CodelParameter>,
    /// Its worst-case execution time, in seconds.
    pub wcet: Option<f64>,
}

/// An argument of a codel.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CodelParameter {
    /// The argument.
    pub name: String,
    /// Whether the codel reads or writes it.
    pub direction: Direction,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Where it comes from: `ids a.b[2]`, `local`, `port NAME`, `remote NAME`.
    pub source: String,
}
