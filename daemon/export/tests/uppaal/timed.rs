//! Which tasks are late, by a structured model and by ourselves.

use genom_export::{Format, export};
use genom_formal::{System, TaskReport, Times};

use super::compare::limits;
use super::explore::{Explorer, Found};
use super::file::Model;

/// What is found of a model with clocks, if it has not more states than that.
pub(crate) fn found(text: &str, most: usize) -> Option<Found> {
    let mut model = Model::new(text);
    // Without this, states differ in clocks that nothing reads.
    let only = |(name, at): &(String, usize)| match name.as_str() {
        "clk" => format!("PERIOD[{at}] != 0"),
        "since" => format!("held[{at}] != 0"),
        other => panic!("clock {other}"),
    };
    let only: Vec<String> = model.clocks().iter().map(only).collect();
    // The last one is of no context.
    let counting: Vec<_> =
        only[..only.len() - 1].iter().map(|text| model.expression(text)).collect();
    let never = model.expression("false");
    let counting = counting.into_iter().chain([never]).enumerate();
    let explorer = Explorer::new(&model);
    counting.fold(explorer, |all, (clock, only)| all.counting(clock, only)).explore(most)
}

/// The model of a component with times.
pub(crate) fn written(system: &System, times: &Times) -> String {
    export(system, Format::Uppaal, Some(times), &limits(0)).unwrap()
}

/// The periodic tasks with whether they are late; `None` if the model has more states than that, or the
/// component more zones.
///
/// # Panics
/// If a task is late in one and not in the other.
pub(crate) fn late(
    system: &System,
    times: &Times,
    states: usize,
    zones: usize,
) -> Option<Vec<(String, bool)>> {
    let report = system.check_times(times, &limits(zones));
    if report.limit().is_some() || report.tasks.is_empty() {
        return None;
    }
    let found = found(&written(system, times), states)?;
    let one = |task: &TaskReport| {
        let late = !found.holds(&format!("overrun: task {} ", task.name));
        assert_eq!(late, task.is_late(), "{}", task.name);
        (task.name.clone(), late)
    };
    Some(report.tasks.iter().map(one).collect())
}
