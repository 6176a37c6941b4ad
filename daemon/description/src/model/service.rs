//! Services and their parameters.

use genom_types::TypeId;

use super::{CodelIx, PathStep, ServiceIx, Span, TaskIx};

/// The three kinds of services (genom3.md 7.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ServiceKind {
    /// Sets and gets members of the IDS.
    Attribute,
    /// Runs simple codels in the control task.
    Function,
    /// Runs a state machine in a task.
    Activity,
}

/// A service.
#[derive(Clone, Debug)]
pub struct Service {
    /// Attribute, function or activity.
    pub kind: ServiceKind,
    /// Name that requests use; unique within the component.
    pub name: String,
    /// `doc`.
    pub doc: Option<String>,
    /// `in`, `out` and `inout` parameters in order.
    pub parameters: Vec<Parameter>,
    /// `local` variables in order.
    pub locals: Vec<Parameter>,
    /// Struct of the `in` and `inout` parameters, in order.
    pub input: TypeId,
    /// Struct of the `out` and `inout` parameters, in order.
    pub output: TypeId,
    /// Struct of the `local` variables, in order.
    pub local: TypeId,
    /// Task that runs the activity.
    pub task: Option<TaskIx>,
    /// Services it interrupts (`all` expanded).
    pub interrupts: Vec<ServiceIx>,
    /// Services it must come before.
    pub before: Vec<ServiceIx>,
    /// Services it must come after.
    pub after: Vec<ServiceIx>,
    /// Validate codels, in order.
    pub validates: Vec<CodelIx>,
    /// Simple codels in order (function), or state-machine codels (activity).
    pub codels: Vec<CodelIx>,
    /// Exceptions it may throw: those of the component, of its task and its own (genom3.md 4.7).
    pub throws: Vec<TypeId>,
    /// Belongs to interface `genom`: the runtime implements it, not the library.
    pub standard: bool,
    /// In the papers' dialects: inputs are stored in the IDS when the service is called, and
    /// outputs read from there at its end, also for activities.
    pub through_ids: bool,
    /// Digest (genom3.md 4.9).
    pub digest: String,
    /// The same without local variables, which callers do not see.
    pub call_digest: String,
    /// Where it is declared.
    pub span: Span,
}

/// Direction of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Passed in.
    In,
    /// Passed out.
    Out,
    /// Passed in, and out again when changed.
    InOut,
}

/// A parameter or local variable of a service.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name, which is that of a member of the input or output struct.
    pub name: String,
    /// Its direction; `InOut` for a local variable.
    pub direction: Direction,
    /// Type as declared, typedefs included.
    pub ty: TypeId,
    /// Doc and default value, for the parameter and for members inside it.
    pub default: Option<Default>,
    /// The IDS member that an attribute (or a service of the papers' dialects) sets and gets.
    pub target: Option<AttributeTarget>,
    /// Where it is declared.
    pub span: Span,
}

/// A member of the IDS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeTarget {
    /// Path from the IDS to the member; empty for the whole IDS.
    pub path: Vec<PathStep>,
}

/// Doc and default values of a parameter, following the shape of its type.
#[derive(Clone, Debug, std::default::Default)]
pub struct Default {
    /// Value in the JSON encoding of genom3.md appendix A; partial objects and index-keyed
    /// objects give some members or elements only.
    pub value: Option<serde_json::Value>,
    /// `: "doc"` of the parameter itself.
    pub doc: Option<String>,
    /// Docs of members inside it, by JSON pointer.
    pub member_docs: Vec<(String, String)>,
}
