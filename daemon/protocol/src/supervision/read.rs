//! What the keys of a rule say together.

use std::time::Duration;

use super::SupervisionEntry;
use super::condition::{
    Beats, Condition, MOST_MISSED, MOST_MS, MOST_REACTIONS, NoRule, WITHIN_MS, Whose, time,
};
use super::formula::Formula;
use super::order::Order;

impl SupervisionEntry {
    /// What must not happen.
    ///
    /// # Errors
    /// Its keys say no rule, or a number is out of range.
    pub fn condition(&self) -> Result<Condition, NoRule> {
        if self.reaction.len() > MOST_REACTIONS {
            return Err(NoRule::ManyReactions(self.reaction.len()));
        }
        condition(self)
    }
}

/// The condition of a rule.
fn condition(entry: &SupervisionEntry) -> Result<Condition, NoRule> {
    let name = |name: &Option<String>| name.clone().unwrap_or_default();
    let (task, codel) = (|| name(&entry.task), || name(&entry.codel));
    let (activity, service) = (|| name(&entry.activity), || name(&entry.service));
    let longest = || time("longest_ms", entry.longest_ms.unwrap_or_default());
    Ok(match keys(entry).as_slice() {
        ["task", "missed"] | ["task", "missed", "within_ms"] => {
            let ticks = entry.missed.unwrap_or_default();
            if !(1..=MOST_MISSED).contains(&ticks) {
                let range = format!("from 1 to {MOST_MISSED}");
                return Err(NoRule::Number { key: "missed", value: ticks.into(), range });
            }
            let within = time("within_ms", entry.within_ms.unwrap_or(WITHIN_MS))?;
            Condition::Missed { task: task(), ticks, within }
        }
        ["task", "longest_ms"] => Condition::Cycle { task: task(), longest: longest()? },
        ["codel", "longest_ms"] => Condition::Longest { codel: codel(), longest: longest()? },
        ["activity", "longest_ms"] => {
            Condition::Activity { activity: activity(), longest: longest()? }
        }
        ["activity", "longest_stop_ms"] => {
            let longest = time("longest_stop_ms", entry.longest_stop_ms.unwrap_or_default())?;
            Condition::Stop { activity: activity(), longest }
        }
        ["wcet"] | ["codel", "wcet"] => Condition::Wcet { codel: entry.codel.clone() },
        ["stuck"] | ["codel", "stuck"] => Condition::Stuck { codel: entry.codel.clone() },
        ["codel", "every_ms"] | ["codel", "every_ms", "while"] => {
            beat(entry, Beats::Codel(codel()))?
        }
        ["port", "every_ms"] | ["port", "every_ms", "while"] => {
            beat(entry, Beats::Port(name(&entry.port)))?
        }
        ["codel", "after"] => Condition::After { codel: codel(), first: name(&entry.after) },
        ["codel", "never_while"] => {
            Condition::NeverWhile { codel: codel(), activity: name(&entry.never_while) }
        }
        ["service", "after"] => {
            Condition::ServiceAfter { service: service(), first: name(&entry.after) }
        }
        ["service", "never_while"] => {
            Condition::ServiceNeverWhile { service: service(), other: name(&entry.never_while) }
        }
        ["task", "from", "to"] => step(entry, Whose::Task(task())),
        ["activity", "from", "to"] => step(entry, Whose::Activity(activity())),
        ["order"] => Condition::Order(Order::read(&entry.order)?),
        ["formula"] => {
            Condition::Formula(Formula::read(entry.formula.as_deref().unwrap_or_default())?)
        }
        _ => return Err(NoRule::Keys),
    })
}

/// The keys that are there, in a fixed order.
fn keys(entry: &SupervisionEntry) -> Vec<&'static str> {
    let all = [
        ("task", entry.task.is_some()),
        ("codel", entry.codel.is_some()),
        ("activity", entry.activity.is_some()),
        ("service", entry.service.is_some()),
        ("port", entry.port.is_some()),
        ("missed", entry.missed.is_some()),
        ("within_ms", entry.within_ms.is_some()),
        ("longest_ms", entry.longest_ms.is_some()),
        ("longest_stop_ms", entry.longest_stop_ms.is_some()),
        ("wcet", entry.wcet),
        ("stuck", entry.stuck),
        ("every_ms", entry.every_ms.is_some()),
        ("while", entry.during.is_some()),
        ("after", entry.after.is_some()),
        ("never_while", entry.never_while.is_some()),
        ("from", entry.from.is_some()),
        ("to", entry.to.is_some()),
        ("order", !entry.order.is_empty()),
        ("formula", entry.formula.is_some()),
    ];
    all.into_iter().filter(|(_, there)| *there).map(|(key, _)| key).collect()
}

fn beat(entry: &SupervisionEntry, of: Beats) -> Result<Condition, NoRule> {
    let [least, longest] = entry.every_ms.unwrap_or_default();
    let last = time("every_ms", longest)?;
    if !(0.0..=MOST_MS).contains(&least) || least >= longest {
        return Err(NoRule::Every(least, longest));
    }
    let first = Duration::from_secs_f64(least / 1e3);
    Ok(Condition::Beat { of, least: first, longest: last, during: entry.during.clone() })
}

fn step(entry: &SupervisionEntry, of: Whose) -> Condition {
    let name = |name: &Option<String>| name.clone().unwrap_or_default();
    Condition::Step { of, from: name(&entry.from), to: name(&entry.to) }
}
