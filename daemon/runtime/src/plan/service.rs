//! Services, compiled for the engine.

use genom_description::model::{
    Component, Indexed, Owner, Service, ServiceIx, ServiceKind, TaskIx,
};
use genom_types::{DataType, TypeTable};

use super::error::PlanError;
use super::event::{Event, EventSet};
use super::machine::Machine;

/// Services that the runtime implements itself (genom3.md 4.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// `abort_activity`.
    AbortActivity,
    /// `connect_port`.
    ConnectPort,
    /// `connect_service`.
    ConnectService,
    /// `kill`.
    Kill,
}

/// A service, compiled.
#[derive(Debug)]
pub struct ServicePlan {
    /// Attribute, function or activity.
    pub kind: ServiceKind,
    /// Record of the `in` and `inout` parameters.
    pub input: DataType,
    /// Record of the `out` and `inout` parameters.
    pub output: DataType,
    /// Exceptions it may throw.
    pub throws: EventSet,
    /// The task of an activity.
    pub task: Option<TaskIx>,
    /// State machine of an activity, by index in [`Plan::machines`](super::Plan::machines).
    pub machine: Option<usize>,
    /// For each service, whether this one interrupts it.
    pub interrupts: Indexed<ServiceIx, bool>,
    /// The runtime's implementation, in place of codels.
    pub builtin: Option<Builtin>,
    /// Whether parameters are stored in the IDS: for attributes, and services of the papers'
    /// dialects.
    pub through_ids: bool,
}

pub(super) fn services(
    model: &Component,
    types: &std::sync::Arc<TypeTable>,
    events: &[Event],
    machines: &[Machine],
) -> Result<Indexed<ServiceIx, ServicePlan>, PlanError> {
    let one = |(ix, service): (ServiceIx, &Service)| {
        let layout = |ty, what: &str| {
            DataType::new(types, ty).map_err(|source| PlanError::Layout {
                component: model.name.clone(),
                what: format!("the {what} of service `{}`", service.name),
                source,
            })
        };
        let mut interrupts = model.services.map(|_, _| false);
        for &other in &service.interrupts {
            interrupts[other] = true;
        }
        let activity = service.kind == ServiceKind::Activity;
        if activity && service.task.is_none() {
            return Err(PlanError::Inconsistent {
                component: model.name.clone(),
                what: format!("activity `{}` has no task", service.name),
            });
        }
        let mine = |machine: &Machine| machine.owner == Owner::Service(ix);
        Ok(ServicePlan {
            kind: service.kind,
            input: layout(service.input, "inputs")?,
            output: layout(service.output, "outputs")?,
            throws: EventSet::of_exceptions(events, &service.throws, types),
            task: service.task,
            machine: machines.iter().position(mine).filter(|_| activity),
            interrupts,
            builtin: builtin(service),
            through_ids: service.through_ids || service.kind == ServiceKind::Attribute,
        })
    };
    model.services.pairs().map(one).collect()
}

fn builtin(service: &Service) -> Option<Builtin> {
    if !service.standard {
        return None;
    }
    match service.name.as_str() {
        "abort_activity" => Some(Builtin::AbortActivity),
        "connect_port" => Some(Builtin::ConnectPort),
        // The name before GenoM3 2.99.24.
        "connect_service" | "connect_remote" => Some(Builtin::ConnectService),
        "kill" => Some(Builtin::Kill),
        _ => None,
    }
}
