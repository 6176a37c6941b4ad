//! Random components with times: which tasks are late, by Spin and by ourselves.

use super::compare::limits;
use super::run::Checked;
use super::small;
use super::tally::Tally;

/// The kind of these verdicts.
pub(crate) const LATE: &str = "overrun";

/// Verdicts of both on each periodic task of a random component; `None` if it has none, or more zones
/// than that. All times are whole milliseconds, which Spin counts one by one.
pub(crate) fn judge(seed: u64, zones: usize) -> Option<Tally> {
    let (system, times) = small::timed(seed);
    let report = system.check_times(&times, &limits(zones));
    if report.limit().is_some() || report.tasks.is_empty() {
        return None;
    }
    let spin = Checked::new(&system, Some(&times));
    let mut tally = Tally::default();
    for task in &report.tasks {
        let claim = format!("in_time_{}", task.name);
        tally.note(LATE, &task.name, Some(!task.is_late()), spin.claim(&claim).map(|late| !late));
    }
    Some(tally)
}
