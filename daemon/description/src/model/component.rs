//! Components, interfaces, tasks, ports and remotes.

use std::time::Duration;

use genom_types::{ScopedName, TypeId};

use super::{
    Codel, CodelIx, Indexed, Ix as _, Parameter, PortIx, RemoteIx, Service, ServiceIx, ServiceKind,
    Span, StateIx, TaskIx,
};

/// Which generation of the language a component was written in (dialects.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// The 2010 paper: `inport`, `event`, `service`, `ids: T;`.
    Paper2010,
    /// The 2011 paper: `inport`, `service`, `ids T { }`.
    Paper2011,
    /// GenoM3 2.99 and later.
    Current,
}

/// A component, with all names resolved and all implicit values filled in.
#[derive(Clone, Debug)]
pub struct Component {
    /// Word after `component`.
    pub name: String,
    /// Generation of the language it was written in.
    pub dialect: Dialect,
    /// `doc`, lines joined.
    pub doc: Option<String>,
    /// `version`, "0" when not given.
    pub version: String,
    /// `lang`, "c" when not given.
    pub lang: String,
    /// `email`.
    pub email: Option<String>,
    /// `require`.
    pub requires: Vec<String>,
    /// `codels-require`.
    pub codels_requires: Vec<String>,
    /// Clock of the component: given, or computed (genom3.md 4.7); `None` without periodic task.
    pub clock_rate: Option<Duration>,
    /// The IDS: a struct type.
    pub ids: Option<TypeId>,
    /// Execution tasks in order of declaration.
    pub tasks: Indexed<TaskIx, Task>,
    /// Ports in order of declaration, those of interface `genom` first.
    pub ports: Indexed<PortIx, Port>,
    /// Remotes, from `uses`.
    pub remotes: Indexed<RemoteIx, Remote>,
    /// Services in order, those of interface `genom` first.
    pub services: Indexed<ServiceIx, Service>,
    /// Codels of tasks and services.
    pub codels: Indexed<CodelIx, Codel>,
    /// State names in order of first use, without scope: `ether`, `start`, `stop`, then others.
    /// `pause::x` is the state `x` with a pause. Where no codel of the machine has the state
    /// `sleep`, yielding it waits for an external event or `stop` (dialects.md A).
    pub states: Indexed<StateIx, String>,
    /// External events: states that an event may activate (dialects.md A).
    pub sinks: Vec<Sink>,
    /// Exceptions any of its services or tasks may throw (genom3.md 4.7).
    pub throws: Vec<TypeId>,
    /// For each codel, then for each service (its data transfer): indices of those that may not run
    /// at the same time (genom3.md 4.5). See [`exclusion`](crate::model::Component::exclusion).
    pub exclusion: Vec<Vec<usize>>,
    /// Digest (genom3.md 4.9).
    pub digest: String,
    /// Where it is declared.
    pub span: Span,
}

impl Component {
    /// Full name of the component's scope.
    #[must_use]
    pub fn scope(&self) -> ScopedName {
        ScopedName::new([self.name.as_str()])
    }

    /// The state with this name: `ether`, `start`, `stop`, or one that a codel has or yields.
    #[must_use]
    pub fn state(&self, name: &str) -> Option<StateIx> {
        self.states.find(|state| state == name)
    }

    /// The number of a node, see [`exclusion`](Self::exclusion).
    #[must_use]
    pub fn node_number(&self, node: Node) -> usize {
        match node {
            Node::Codel(codel) => codel.index(),
            Node::Transfer(service) => self.codels.len() + service.index(),
        }
    }

    /// The node with this number. Whether the component has it is for the caller to check.
    #[must_use]
    pub fn node(&self, number: usize) -> Node {
        match number.checked_sub(self.codels.len()) {
            None => Node::Codel(CodelIx::new(number)),
            Some(service) => Node::Transfer(ServiceIx::new(service)),
        }
    }

    /// The codel that the node with this number stands for; `None` for a data transfer.
    #[must_use]
    pub fn codel_of_node(&self, number: usize) -> Option<&Codel> {
        match self.node(number) {
            Node::Codel(codel) => self.codels.get(codel),
            Node::Transfer(_) => None,
        }
    }

    /// The nodes that may not run while `node` runs.
    ///
    /// Nodes `0..codels.len()` are the codels; node `codels.len() + s` is the data transfer of
    /// attribute `s`, or of service `s` of the papers (`through_ids`). The relation is as genom3.md
    /// 4.5 computes it, not always symmetric.
    #[must_use]
    pub fn exclusion(&self, node: usize) -> &[usize] {
        self.exclusion.get(node).map_or(&[], Vec::as_slice)
    }
}

/// What may not run at the same time as another, see [`Component::exclusion`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A codel.
    Codel(CodelIx),
    /// The data transfer of a service.
    Transfer(ServiceIx),
}

/// An interface: a partial component that others provide or use.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Word after `interface`.
    pub name: String,
    /// `doc`, lines joined.
    pub doc: Option<String>,
    /// Names of the ports it declares.
    pub ports: Vec<String>,
    /// Names of the services it declares.
    pub services: Vec<String>,
    /// Where it is declared.
    pub span: Span,
}

/// An execution task.
#[derive(Clone, Debug)]
pub struct Task {
    /// Word after `task`; unique within the component.
    pub name: String,
    /// `doc`.
    pub doc: Option<String>,
    /// `period`; `None` for an aperiodic task.
    pub period: Option<Duration>,
    /// `delay`: phase offset within the period.
    pub delay: Duration,
    /// `priority`: 0 is the highest, 255 the lowest.
    pub priority: Option<u32>,
    /// `scheduling real-time`.
    pub real_time: bool,
    /// `stack`, in bytes.
    pub stack: Option<u64>,
    /// State-machine codels of its permanent activity.
    pub codels: Vec<CodelIx>,
    /// Exceptions its codels may throw: the component's and its own.
    pub throws: Vec<TypeId>,
    /// Where it is declared.
    pub span: Span,
}

/// Which way the data of a port flows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortDirection {
    /// Read by the component.
    In,
    /// Written by the component.
    Out,
}

impl PortDirection {
    /// Its keyword in a description: `in` or `out`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::In => "in",
            Self::Out => "out",
        }
    }
}

/// A data port.
#[derive(Clone, Debug)]
pub struct Port {
    /// Name without that of the component: `position` of `demo/position`.
    pub name: String,
    /// Whether the component reads or writes it.
    pub direction: PortDirection,
    /// `port multiple`: a set of elements opened by id at run time.
    pub multiple: bool,
    /// The interface that it comes from, unless `uses` reversed its direction: some headers of
    /// GenoM3 name the port's handle after the interface.
    pub interface: Option<String>,
    /// Type of the data.
    pub ty: TypeId,
    /// `doc`.
    pub doc: Option<String>,
    /// Where it is declared.
    pub span: Span,
}

/// A service of another component that codels call.
#[derive(Clone, Debug)]
pub struct Remote {
    /// Name of the service in the used interface.
    pub name: String,
    /// The interface it comes from.
    pub interface: String,
    /// Attribute, function or activity.
    pub kind: ServiceKind,
    /// Parameters in order.
    pub parameters: Vec<Parameter>,
    /// Struct of the `in` and `inout` parameters.
    pub input: TypeId,
    /// Struct of the `out` and `inout` parameters.
    pub output: TypeId,
    /// Exceptions the service may throw.
    pub throws: Vec<TypeId>,
    /// [`call_digest`](super::Service::call_digest) that the provider's service must have.
    pub digest: String,
    /// Where it is declared.
    pub span: Span,
}

/// An external event that activates a state (dialects.md A).
#[derive(Clone, Debug)]
pub struct Sink {
    /// Its name, also that of the state.
    pub name: String,
    /// The state.
    pub state: StateIx,
    /// Where it is declared, or first used in the 2011 dialect.
    pub span: Span,
}
