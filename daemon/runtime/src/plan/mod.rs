//! A component compiled into flat arrays, which the engine reads at run time.
//!
//! No task looks up names while it runs. A plan holds no memory of instances.

mod conflict;
mod error;
mod event;
mod ix16;
mod machine;
mod node;
mod owner;
mod service;
mod yields;

use std::collections::HashMap;
use std::sync::Arc;

use genom_description::model::{
    CodelIx, Component, Dialect, Indexed, Ix as _, PortDirection, PortIx, ServiceIx, Specification,
    StateIx,
};
use genom_types::DataType;

use crate::body::EventId;

pub use error::PlanError;
pub use event::{Event, EventSet, Meaning};
pub use ix16::Ix16;
pub use machine::{Machine, Transition};
pub use node::Nodes;
pub(crate) use owner::owner_name;
pub use service::{Builtin, ServicePlan};
pub(crate) use yields::Yields;

/// Limit on the codels of a component: machines hold their indices in 16 bits, see [`Ix16`].
const MOST_CODELS: usize = 1 << 16;
/// Limit on requests served in parallel, however many services there are: each needs a thread and a
/// `genom_context`. Further requests wait for a free one.
pub const MOST_CONTROL_WORKERS: usize = 64;

/// A compiled component. One plan serves all its instances.
#[derive(Debug)]
pub struct Plan {
    specification: Arc<Specification>,
    component: usize,
    events: Vec<Event>,
    by_name: HashMap<String, EventId>,
    /// For each codel, the transition of each event; empty for codels outside state machines.
    transitions: Indexed<CodelIx, Box<[Transition]>>,
    /// Machines of permanent activities by task, then of services, see [`ServicePlan::machine`].
    machines: Vec<Machine>,
    services: Indexed<ServiceIx, ServicePlan>,
    /// For each codel, where what it returns is counted.
    yields: Indexed<CodelIx, Yields>,
    nodes: Nodes,
    /// Type of each port, in the model's order.
    ports: Indexed<PortIx, DataType>,
    /// The port that the runtime writes (genom3.md 4.8), if the component has it.
    state_port: Option<PortIx>,
}

impl Plan {
    /// Compiles the component with index `component` of the specification.
    ///
    /// # Errors
    /// A type has no layout, or the model refers to something that does not exist.
    pub fn new(specification: &Arc<Specification>, component: usize) -> Result<Self, PlanError> {
        let Some(model) = specification.components.get(component) else {
            let known = specification.components.len();
            return Err(PlanError::NoComponent { component, known });
        };
        check_indices(model)?;
        let events = event::table(model, &specification.types)?;
        let by_name = events
            .iter()
            .zip(0u16..)
            .map(|(event, rank)| (event.name.clone(), EventId(rank)))
            .collect();
        let machines = machine::machines(model)?;
        let transitions = machine::transitions(model, &events, &machines);
        let services = service::services(model, &specification.types, &events, &machines)?;
        let yields = yields::yields(model, &transitions, &services);
        let nodes = Nodes::new(model);
        let mut ports = Vec::new();
        for port in &model.ports {
            ports.push(layout(model, specification, port.ty, || format!("port `{}`", port.name))?);
        }
        let state_port = model
            .ports
            .find(|port| port.name == "genom_state" && port.direction == PortDirection::Out);
        Ok(Self {
            specification: Arc::clone(specification),
            component,
            events,
            by_name,
            transitions,
            machines,
            services,
            yields,
            nodes,
            ports: ports.into_iter().collect(),
            state_port,
        })
    }

    /// The specification that holds the component.
    #[must_use]
    pub fn specification(&self) -> &Arc<Specification> {
        &self.specification
    }

    /// Index of the component in its specification.
    #[must_use]
    pub fn component_index(&self) -> usize {
        self.component
    }

    /// The model of the component.
    #[must_use]
    pub fn component(&self) -> &Component {
        &self.specification.components[self.component]
    }

    /// Events by index: the strings that codels may return.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Full names of the events, by index.
    #[must_use]
    pub fn event_names(&self) -> Vec<String> {
        self.events.iter().map(|event| event.name.clone()).collect()
    }

    /// The event with this full name (`::demo::main`).
    #[must_use]
    pub fn event(&self, name: &str) -> Option<EventId> {
        self.by_name.get(name).copied()
    }

    /// Full name of an event.
    #[must_use]
    pub fn event_name(&self, event: EventId) -> &str {
        self.events.get(usize::from(event.0)).map_or("", |event| event.name.as_str())
    }

    /// The state that an event names, with or without a pause.
    #[must_use]
    pub fn state_of(&self, event: EventId) -> Option<StateIx> {
        match self.events.get(usize::from(event.0))?.meaning {
            Meaning::State { state, .. } => Some(state),
            Meaning::Exception(_) => None,
        }
    }

    /// Full name of a state (`::demo::main`).
    #[must_use]
    pub fn state_name(&self, state: StateIx) -> &str {
        // States come first in the table, in the model's order.
        self.events.get(state.index()).map_or("", |event| event.name.as_str())
    }

    /// Services, in the model's order.
    #[must_use]
    pub fn services(&self) -> &Indexed<ServiceIx, ServicePlan> {
        &self.services
    }

    /// The service with this name.
    #[must_use]
    pub fn service(&self, name: &str) -> Option<ServiceIx> {
        self.component().services.find(|service| service.name == name)
    }

    /// State machines: those of permanent activities by task, then those of services.
    #[must_use]
    pub fn machines(&self) -> &[Machine] {
        &self.machines
    }

    /// Transition of each event when this codel returns it.
    #[must_use]
    pub fn transitions(&self, codel: CodelIx) -> &[Transition] {
        self.transitions.get(codel).map_or(&[], |table| table)
    }

    /// Where what this codel returns is counted.
    #[inline]
    pub(crate) fn yields(&self, codel: CodelIx) -> &Yields {
        &self.yields[codel]
    }

    /// The exclusion nodes and their conflicts.
    #[must_use]
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Type of a port's data.
    #[must_use]
    pub fn port_type(&self, port: PortIx) -> Option<&DataType> {
        self.ports.get(port)
    }

    /// The port with the component's state, `genom_state` (genom3.md 4.8), if it has one.
    #[must_use]
    pub fn state_port(&self) -> Option<PortIx> {
        self.state_port
    }

    /// Number of `genom_context`s that an instance needs: one for each task, then one for each
    /// control worker, see [`Frame::call`](crate::body::Frame::call).
    #[must_use]
    pub fn contexts(&self) -> usize {
        self.component().tasks.len() + self.control_workers()
    }

    /// Number of requests served in parallel. Those of one service are served one by one, so with
    /// one worker for each service none waits for another service that blocks.
    #[must_use]
    pub fn control_workers(&self) -> usize {
        self.services.len().clamp(1, MOST_CONTROL_WORKERS)
    }

    /// Whether each token takes one transition per period (dialects.md A), as in both papers; so a
    /// component runs alike in either of their notations.
    #[must_use]
    pub fn steps_by_period(&self) -> bool {
        self.component().dialect != Dialect::Current
    }
}

fn layout(
    model: &Component,
    specification: &Specification,
    ty: genom_types::TypeId,
    what: impl FnOnce() -> String,
) -> Result<DataType, PlanError> {
    DataType::new(&specification.types, ty).map_err(|source| PlanError::Layout {
        component: model.name.clone(),
        what: what(),
        source,
    })
}

/// Checks all indices of the model once, so that the engine does not have to at run time.
fn check_indices(model: &Component) -> Result<(), PlanError> {
    if model.codels.len() > MOST_CODELS {
        let (component, count) = (model.name.clone(), model.codels.len());
        return Err(PlanError::TooManyCodels { component, count });
    }
    let services = &model.services;
    let ok_codels = |list: &[CodelIx]| list.iter().all(|ix| model.codels.get(*ix).is_some());
    let ok_services = |list: &[ServiceIx]| list.iter().all(|ix| services.get(*ix).is_some());
    let inconsistent =
        |what: String| Err(PlanError::Inconsistent { component: model.name.clone(), what });
    for service in &model.services {
        let fine = ok_codels(&service.codels)
            && ok_codels(&service.validates)
            && ok_services(&service.interrupts)
            && ok_services(&service.before)
            && ok_services(&service.after)
            && service.task.is_none_or(|task| model.tasks.get(task).is_some());
        if !fine {
            return inconsistent(format!("service `{}`", service.name));
        }
    }
    if let Some(task) = model.tasks.iter().find(|task| !ok_codels(&task.codels)) {
        return inconsistent(format!("task `{}`", task.name));
    }
    if let Some(sink) = model.sinks.iter().find(|sink| model.states.get(sink.state).is_none()) {
        return inconsistent(format!("event `{}`", sink.name));
    }
    Ok(())
}
