//! Random components with times: which tasks are late, by Spin and by ourselves.

use genom_formal::{Bounds, Duration, System};

use super::compare::limits;
use super::random::Random;
use super::run::Checked;
use super::small;
use super::tally::Tally;

/// The kind of these verdicts.
pub(crate) const LATE: &str = "overrun";

/// Verdicts of both on each periodic task of a random component; `None` if it has none, or more zones
/// than that. All times are whole milliseconds, which Spin counts one by one.
pub(crate) fn judge(seed: u64, zones: usize) -> Option<Tally> {
    const MS: u64 = 1_000_000;
    let system = small::random(seed);
    let bounds = Bounds { kill: false, instances: 1, requests: 1, fire: false, ..*system.bounds() };
    let system = System::new(system.plan(), bounds);
    let component = system.plan().component();
    let (mut times, mut random) = (system.declared_times(), Random(seed));
    for codel in component.codels.iter() {
        let most = u64::try_from(random.below(4)).unwrap();
        let least = if random.percent(30) { most / 2 } else { 0 };
        let duration = Duration { least: least * MS, most: Some(most * MS) };
        times.set(component, &codel.name, duration);
    }
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
