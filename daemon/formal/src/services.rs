//! Services: what the worker of a request does, in order, and what that changes.

use genom_description::model::{Ix as _, ServiceIx, ServiceKind};
use genom_runtime::plan::{Builtin, Plan};

use crate::codels::small;

/// A service.
#[derive(Clone, Debug)]
pub struct Service {
    /// The machine of an activity, by index.
    pub machine: Option<u16>,
    /// What a worker does before it concludes.
    pub work: Vec<Work>,
    /// For each service, whether this one interrupts it.
    pub interrupts: Vec<bool>,
    /// Services that must not have run.
    pub before: Vec<u16>,
    /// Services that must have run.
    pub after: Vec<u16>,
    /// A `before` or `after` names it.
    pub ordered: bool,
    /// The runtime implements it.
    pub builtin: Option<Builtin>,
}

/// An item of a worker's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// A codel, whose node has the same number.
    Codel(u16),
    /// A data transfer, by node.
    Transfer(u16),
    /// The stop of an activity by `abort_activity`.
    Abort,
}

pub(crate) fn services(plan: &Plan) -> Vec<Service> {
    let model = plan.component();
    let named = |ix: ServiceIx| {
        model.services.iter().any(|other| other.before.contains(&ix) || other.after.contains(&ix))
    };
    let list = |list: &[ServiceIx]| list.iter().map(|ix| small(ix.index())).collect();
    let one = |ix: ServiceIx| {
        let (service, compiled) = (&model.services[ix], &plan.services()[ix]);
        Service {
            machine: compiled.machine.map(small),
            work: work(plan, ix),
            interrupts: compiled.interrupts.iter().copied().collect(),
            before: list(&service.before),
            after: list(&service.after),
            ordered: named(ix),
            builtin: compiled.builtin,
        }
    };
    model.services.places().map(one).collect()
}

/// genom3.md 7.3.5 to 7.3.7.
fn work(plan: &Plan, ix: ServiceIx) -> Vec<Work> {
    let (service, compiled) = (&plan.component().services[ix], &plan.services()[ix]);
    match compiled.builtin {
        Some(Builtin::AbortActivity) => return vec![Work::Abort],
        Some(_) => return Vec::new(),
        None => {}
    }
    let codels = |list: &[genom_description::model::CodelIx]| -> Vec<Work> {
        list.iter().map(|codel| Work::Codel(small(codel.index()))).collect()
    };
    let transfer = Work::Transfer(small(plan.nodes().transfer(ix)));
    let mut work = codels(&service.validates);
    work.extend(compiled.through_ids.then_some(transfer));
    if compiled.kind != ServiceKind::Activity {
        work.extend(codels(&service.codels));
        let fetches = compiled.through_ids && compiled.kind == ServiceKind::Function;
        work.extend(fetches.then_some(transfer));
    }
    work
}
