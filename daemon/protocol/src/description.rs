//! The interface of a component, as its description specifies it.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::Display;

use crate::{Component, PortDirection};

/// A running component with the content of its description.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Description {
    /// What belongs to this instance.
    #[serde(flatten)]
    pub instance: Component,
    /// Dialect of the description: `current`, or `2010` or `2011` for the languages of the papers
    /// of these years.
    #[serde(default)]
    pub dialect: String,
    /// Documentation of the component.
    pub doc: Option<String>,
    /// Version of the component.
    pub version: String,
    /// `c`, `c++` or `rust`: the language of its codels.
    #[serde(default)]
    pub lang: String,
    /// Address of its author.
    pub email: Option<String>,
    /// Packages that users of the component need.
    #[serde(default)]
    pub requires: Vec<String>,
    /// Packages that its codels need.
    #[serde(default)]
    pub codels_requires: Vec<String>,
    /// Period of the clock of its tasks, in seconds.
    pub clock_rate: Option<f64>,
    /// Members of its internal data structure (IDS).
    pub ids: Option<Vec<Member>>,
    /// Its execution tasks.
    pub tasks: Vec<TaskDescription>,
    /// Its ports.
    pub ports: Vec<PortDescription>,
    /// Services of other components that its codels call.
    #[serde(default)]
    pub uses: Vec<RemoteDescription>,
    /// Its services, including those that every component has.
    pub services: Vec<Service>,
    /// Names of all states of its codels.
    #[serde(default)]
    pub states: Vec<String>,
    /// Events that can be fired from outside.
    #[serde(default)]
    pub events: Vec<String>,
    /// Exceptions that its codels may raise.
    #[serde(default)]
    pub throws: Vec<String>,
    /// Digest of all of this: equal for components of the same interface.
    #[serde(default)]
    pub digest: String,
}

/// A member of the IDS.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Member {
    /// Name of the member.
    pub name: String,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
}

/// An execution task. Times are in seconds.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskDescription {
    /// Name of the task.
    pub name: String,
    /// Documentation.
    pub doc: Option<String>,
    /// Its period; absent if it is aperiodic.
    pub period: Option<f64>,
    /// Offset of its ticks from the start of each period.
    #[serde(default)]
    pub delay: f64,
    /// From 0, the highest, to 255.
    pub priority: Option<u32>,
    /// Whether it requests real-time scheduling.
    #[serde(default)]
    pub real_time: bool,
    /// Size of its stack, in bytes.
    pub stack: Option<u64>,
    /// Codels of its permanent activity.
    #[serde(default)]
    pub codels: Vec<Codel>,
    /// Exceptions that these codels may raise.
    #[serde(default)]
    pub throws: Vec<String>,
}

/// A port of a component.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortDescription {
    /// Name of the port.
    pub name: String,
    /// Whether the component reads (`in`) or writes (`out`) it.
    pub direction: PortDirection,
    /// Whether it has elements.
    pub multiple: bool,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Documentation.
    pub doc: Option<String>,
}

/// A remote: a service of another component that codels call.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RemoteDescription {
    /// Name of the remote.
    pub name: String,
    /// Name of the interface that declares the service.
    pub interface: String,
    /// Parameters of the service.
    pub parameters: Vec<Parameter>,
    /// Exceptions that the service may end with.
    #[serde(default)]
    pub throws: Vec<String>,
    /// The [`Service::call_digest`] that a service must have to be connected.
    #[serde(default)]
    pub digest: String,
}

/// A service: an attribute, a function or an activity.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Service {
    /// Name of the service.
    pub name: String,
    /// What kind of service it is.
    pub kind: ServiceKind,
    /// Whether every component has it.
    #[serde(default)]
    pub standard: bool,
    /// Documentation.
    pub doc: Option<String>,
    /// Its inputs and outputs.
    pub parameters: Vec<Parameter>,
    /// Local variables of its codels.
    #[serde(default)]
    pub locals: Vec<Parameter>,
    /// Task that runs it; absent for attributes and functions.
    pub task: Option<String>,
    /// Services that it interrupts when it starts.
    #[serde(default)]
    pub interrupts: Vec<String>,
    /// Services whose success disallows this one: it comes before them.
    #[serde(default)]
    pub before: Vec<String>,
    /// Services that must have succeeded once before this one is allowed.
    #[serde(default)]
    pub after: Vec<String>,
    /// Codels that validate its inputs before it starts.
    #[serde(default)]
    pub validates: Vec<Codel>,
    /// Its codels.
    #[serde(default)]
    pub codels: Vec<Codel>,
    /// Exceptions that it may end with.
    #[serde(default)]
    pub throws: Vec<String>,
    /// Digest of its whole description.
    #[serde(default)]
    pub digest: String,
    /// Digest of the parts that concern its callers.
    #[serde(default)]
    pub call_digest: String,
    /// Middlewares that it is offered on (`[services]` of the daemon's configuration).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub served: Option<Vec<String>>,
    /// JSON Schema of its inputs; only if the service was requested by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_schema: Option<Value>,
    /// JSON Schema of its outputs; only if the service was requested by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_schema: Option<Value>,
}

/// Kind of a service.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum ServiceKind {
    /// Reads or sets members of the IDS; replies at once.
    Attribute,
    /// Computes something; replies at once.
    Function,
    /// Runs through states for a while and then gives a result; can be aborted.
    Activity,
}

/// A parameter of a service.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Parameter {
    /// Name of the parameter.
    pub name: String,
    /// Whether it is an input, an output, or both.
    pub direction: Direction,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Value used if the input is left out; not used by attributes.
    pub default: Option<Value>,
    /// Documentation.
    pub doc: Option<String>,
    /// For an input of an attribute that was requested by name: the present value, which is kept if
    /// the input is left out. Only for clients that may call the attribute, and only if no codel
    /// excludes reading it now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current: Option<Value>,
}

/// Direction of a parameter.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Direction {
    /// An input.
    In,
    /// An output.
    Out,
    /// An input and an output.
    InOut,
}

impl Direction {
    /// Whether the parameter is an input.
    #[must_use]
    pub fn is_input(self) -> bool {
        self != Self::Out
    }
}

/// A codel: a function of the component's library.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Codel {
    /// Name of the codel.
    pub name: String,
    /// Whether it runs in a thread of its own (`async`).
    #[serde(rename = "async")]
    pub asynchronous: bool,
    /// States in which it runs; only in a state machine.
    pub on: Option<Vec<String>>,
    /// States that it may yield, with `pause::` before those that wait for the next tick or event.
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
    /// Name of the argument.
    pub name: String,
    /// Whether the codel reads or writes it.
    pub direction: Direction,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// What it refers to: `ids a.b[2]`, `local`, `port NAME`, `remote NAME`.
    pub source: String,
}
