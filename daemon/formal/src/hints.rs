//! What can be said of a component while its description is typed: without looking at states.

use std::sync::Arc;

use genom_description::model::{Codel, CodelKind, Owner, Span, Specification, Task};
use genom_runtime::plan::Plan;

use crate::bounds::Bounds;
use crate::property::{Property, Verdict};
use crate::system::System;
use genom_timing::Limits;

/// Codels and services of a component, at most: an editor waits for the hints.
const MOST: usize = 300;

/// Something that will not work as described.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hint {
    /// The property that does not hold.
    pub property: &'static str,
    /// What is wrong, in a sentence.
    pub what: String,
    /// Where that is declared.
    pub span: Option<Span>,
}

/// Hints on the components of a specification without errors; none on those of unusual size.
#[must_use]
pub fn hints(specification: &Arc<Specification>) -> Vec<Hint> {
    let components = specification.components.iter().enumerate();
    let usual = components.filter(|(_, one)| one.codels.len() + one.services.len() <= MOST);
    let plans = usual.filter_map(|(place, _)| Plan::new(specification, place).ok());
    plans.flat_map(|plan| of_component(&Arc::new(plan))).collect()
}

fn of_component(plan: &Arc<Plan>) -> Vec<Hint> {
    let system = System::new(plan, Bounds::default());
    // Loops are not among them: the description's own warnings tell of them (W0950, W0951).
    let cheap = [Property::Stop, Property::Order];
    let report = system.check(&cheap, &Limits::default());
    let mut hints = Vec::new();
    for (property, verdict) in report.verdicts {
        let Verdict::Violated(found) = verdict else { continue };
        let property = property.name();
        let hint = |found: crate::Finding| Hint { property, what: found.what, span: found.span };
        hints.extend(found.into_iter().map(hint));
    }
    for codel in &plan.component().codels {
        // Codels that control calls have no period to keep.
        let machine = matches!(codel.kind, CodelKind::Fsm { .. });
        let Some(task) = task_of(plan, codel).filter(|_| machine) else { continue };
        if let (Some(wcet), Some(period)) = (codel.wcet, task.period)
            && wcet >= period
        {
            let what = format!(
                "{} takes up to {} ms, and {} has a tick each {} ms",
                codel.name,
                wcet.as_secs_f64() * 1e3,
                task.name,
                period.as_secs_f64() * 1e3,
            );
            hints.push(Hint { property: "overrun", what, span: Some(codel.span) });
        }
    }
    hints
}

/// The task that runs a codel.
fn task_of<'p>(plan: &'p Plan, codel: &Codel) -> Option<&'p Task> {
    let model = plan.component();
    let task = match codel.owner {
        Owner::Task(task) => Some(task),
        Owner::Service(service) => model.services[service].task,
    };
    task.map(|task| &model.tasks[task])
}
