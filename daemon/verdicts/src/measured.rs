//! Times of codels as they were measured of a component that runs.

use genom_description::model::{Codel, Component, Owner};
use genom_drawing::units::duration;
use genom_formal::{Duration, Times};
use genom_protocol::{CodelStatistics, Statistics};
use genom_runtime::nanos;
use serde_json::{Value, json};

/// Calls before a greatest time is believed.
const ENOUGH: u64 = 1000;

/// What is taken as the time of a codel.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Taken {
    /// What was measured.
    Measured,
    /// Its `wcet`.
    Stated,
    /// Nothing: it ran too seldom, and has no `wcet`.
    Nothing,
}

/// What was measured of a codel, and what is taken.
#[derive(Clone, Debug)]
struct One {
    codel: String,
    calls: u64,
    least: u64,
    most: u64,
    stated: Option<u64>,
    taken: Taken,
}

impl One {
    /// It took longer than it may.
    fn is_too_long(&self) -> bool {
        self.stated.is_some_and(|stated| self.most > stated)
    }
}

/// What was measured of all codels of a component, in the order of its description.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    all: Vec<One>,
    margin: f64,
}

impl Measured {
    /// Takes the times of codels that ran often enough: at least the shortest one measured; at most
    /// the `wcet` if it is stated and was kept, else the longest one times the margin.
    pub fn take(
        times: &mut Times,
        component: &Component,
        statistics: &Statistics,
        margin: f64,
    ) -> Self {
        let mut all = Vec::new();
        for (ix, codel) in component.codels.pairs() {
            let Some(owner) = owner(component, codel) else { continue };
            let is = |one: &&CodelStatistics| one.name == codel.name && one.owner == owner;
            let found = statistics.codels.iter().find(is).map(|one| one.durations);
            let found = found.unwrap_or_default();
            let stated = codel.wcet.map(nanos);
            let kept = stated.filter(|stated| found.max_ns <= *stated);
            let enough = found.count >= ENOUGH;
            let taken = match (kept, stated, enough) {
                (Some(_), ..) | (_, Some(_), false) => Taken::Stated,
                (None, _, true) => Taken::Measured,
                (None, None, false) => Taken::Nothing,
            };
            let most = match taken {
                Taken::Measured => Some(scaled(found.max_ns, margin)),
                // A longer time was seen, though seldom.
                Taken::Stated => stated.map(|stated| stated.max(found.max_ns)),
                Taken::Nothing => None,
            };
            let least = if enough { found.min_ns } else { 0 };
            let least = most.map_or(least, |most| least.min(most));
            times.set_one(ix, Duration { least, most });
            all.push(One {
                codel: codel.name.clone(),
                calls: found.count,
                least: found.min_ns,
                most: found.max_ns,
                stated,
                taken,
            });
        }
        Self { all, margin }
    }

    /// Codels that took longer than their `wcet`.
    #[must_use]
    pub fn violated(&self) -> usize {
        self.all.iter().filter(|one| one.is_too_long()).count()
    }

    /// What was measured and taken, for people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for one in &self.all {
            let (least, most) = (duration(one.least), duration(one.most));
            let what = match (&one.taken, one.stated) {
                (Taken::Measured, _) => {
                    format!("{least} to {most} in {} calls, times {}", one.calls, self.margin)
                }
                (Taken::Stated, stated) => {
                    let stated = duration(stated.unwrap_or(0));
                    format!("wcet {stated}; {least} to {most} in {} calls", one.calls)
                }
                (Taken::Nothing, _) => {
                    format!("{} calls, and {ENOUGH} are needed", one.calls)
                }
            };
            text.push_str(&format!("  {}: {what}\n", one.codel));
        }
        for one in self.all.iter().filter(|one| one.is_too_long()) {
            text.push_str(&format!(
                "measured VIOLATED\n  {} took {}, and its wcet is {}\n",
                one.codel,
                duration(one.most),
                duration(one.stated.unwrap_or(0)),
            ));
        }
        text
    }

    /// The same as JSON.
    #[must_use]
    pub fn data(&self) -> Value {
        let one = |one: &One| {
            json!({
                "codel": one.codel, "calls": one.calls, "least_ns": one.least,
                "most_ns": one.most, "wcet_ns": one.stated, "above_wcet": one.is_too_long(),
                "taken": match one.taken {
                    Taken::Measured => "measured",
                    Taken::Stated => "wcet",
                    Taken::Nothing => "nothing",
                },
            })
        };
        json!(self.all.iter().map(one).collect::<Vec<_>>())
    }
}

/// A time with the margin.
#[allow(clippy::cast_precision_loss, reason = "durations are far below 2^52 ns")]
fn scaled(ns: u64, margin: f64) -> u64 {
    (ns as f64 * margin).ceil() as u64
}

/// The name that statistics give the owner of a codel; none for services that every component has.
fn owner<'a>(component: &'a Component, codel: &Codel) -> Option<&'a str> {
    match codel.owner {
        Owner::Task(task) => Some(&component.tasks[task].name),
        Owner::Service(service) => {
            let service = &component.services[service];
            (!service.standard).then_some(service.name.as_str())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_description::{Options, read_text};

    fn measured(calls: u64, max: u64) -> (Measured, Times, Component) {
        let text = "component c { task t { period 10 ms;
            codel<start> stated() yield free wcet 2 ms;
            codel<free> free() yield pause::start; }; };";
        let analysis = read_text("c.gen", text, &Options::default());
        let component = analysis.specification.components[0].clone();
        let durations = serde_json::json!({
            "count": calls, "last_ns": 0, "mean_ns": 0, "p50_ns": 0, "p99_ns": 0,
            "min_ns": 1_000, "max_ns": max,
        });
        let codel = |name: &str| {
            serde_json::json!({
                "name": name, "owner": "t", "durations": durations, "wcet_ns": null,
                "above_wcet": 0,
            })
        };
        let statistics = serde_json::from_value(serde_json::json!({
            "tasks": [], "codels": [codel("stated"), codel("free")], "lost_changes": 0,
        }));
        let mut times = Times::declared(&component);
        let measured = Measured::take(&mut times, &component, &statistics.unwrap(), 1.5);
        (measured, times, component)
    }

    #[test]
    fn what_ran_often_enough_takes_what_was_measured_with_a_margin() {
        let (found, times, component) = measured(ENOUGH, 1_000_000);
        assert_eq!(found.violated(), 0);
        let mut expected = Times::declared(&component);
        let stated = Duration { least: 1_000, most: Some(2_000_000) };
        expected.set(&component, "stated", stated);
        let free = Duration { least: 1_000, most: Some(1_500_000) };
        expected.set(&component, "free", free);
        assert_eq!(times, expected);
    }

    #[test]
    fn what_ran_seldom_is_not_believed() {
        let (_, times, component) = measured(ENOUGH - 1, 1_000_000);
        assert_eq!(times, Times::declared(&component));
        assert_eq!(times.unbounded(&component), ["free"]);
    }

    #[test]
    fn a_codel_that_took_longer_than_its_wcet_is_a_finding_and_counts_as_measured() {
        let (found, times, component) = measured(ENOUGH, 3_000_000);
        assert_eq!(found.violated(), 1);
        assert!(found.text().contains("stated took 3.000 ms, and its wcet is 2.000 ms"));
        let mut expected = times.clone();
        let most = Some(4_500_000);
        expected.set(&component, "stated", Duration { least: 1_000, most });
        assert_eq!(times, expected);
    }
}
