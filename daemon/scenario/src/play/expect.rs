//! The steps that compare something with what it has to be.

use std::collections::BTreeMap;

use genom_nearest::suggest;
use genom_protocol::{Codel, Description, routes};
use serde_json::Value;

use super::act::element;
use super::daemon::Daemon;
use super::player::Player;
use super::why::Why;
use crate::compare::{differences, told};
use crate::model::{Codels, Expected};

impl<D: Daemon> Player<'_, D> {
    pub(super) async fn expect(&self, expected: &Expected) -> Result<(), Why> {
        match expected {
            Expected::Port { port, value, tolerance, absent, samples } => {
                let route = routes::port(&port.component, &port.port).with(&element(port));
                let found = self.daemon.ask(route).await?;
                if let Some(wanted) = value {
                    compare(wanted, found.value.as_ref(), *tolerance)?;
                }
                if let Some(value) = found.value.filter(|_| *absent) {
                    return Err(Why::unmet("no value", value.to_string()));
                }
                let count = found.traffic.unwrap_or_default().samples;
                equal(samples.as_ref(), &count, "samples")
            }
            Expected::Activity { of, states, running } => {
                let activity = self.activity(of).await?;
                if let Some(wanted) = running {
                    let runs = self.end(&activity).await?.is_none();
                    if runs != *wanted {
                        let text = |runs| if runs { "that it runs" } else { "that it has ended" };
                        return Err(Why::unmet(text(*wanted), text(runs)));
                    }
                }
                let Some(states) = states else { return Ok(()) };
                self.all_told(&activity.component).await?;
                let life = self.life(&activity.component, activity.number).await?;
                if life.states == *states {
                    return Ok(());
                }
                Err(Why::unmet(path(states), path(&life.states)))
            }
            Expected::Component { name, codels, missed, state } => {
                if let Some(wanted) = state {
                    let all = self.daemon.ask(routes::components()).await?.components;
                    let found = all.into_iter().find(|one| one.name == *name);
                    let found = found.map_or_else(|| "not loaded".to_owned(), |one| one.state);
                    if found != *wanted {
                        return Err(Why::unmet(wanted, found));
                    }
                }
                if missed.is_none() && codels.is_none() {
                    return Ok(());
                }
                let statistics = self.daemon.ask(routes::statistics(name)).await?;
                let all = statistics.tasks.iter().map(|task| task.overruns).sum();
                equal(missed.as_ref(), &all, "missed")?;
                let Some(codels) = codels else { return Ok(()) };
                let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
                for codel in &statistics.codels {
                    *counts.entry(&codel.name).or_default() += codel.durations.count;
                }
                self.known(name, codels).await?;
                ran(codels, &counts)
            }
        }
    }

    /// Fails if the component reported less than happened.
    async fn all_told(&self, component: &str) -> Result<(), Why> {
        match self.daemon.ask(routes::statistics(component)).await?.lost_changes {
            0 => Ok(()),
            lost => {
                Err(Why::unmet("all states", format!("{lost} changes came too fast to be told")))
            }
        }
    }

    /// Fails if the component does not have one of these codels: it would never run.
    async fn known(&self, component: &str, codels: &Codels) -> Result<(), Why> {
        let description = self.daemon.ask(routes::component(component)).await?;
        let known = names(&description);
        let wanted: Vec<&str> = match codels {
            Codels::Ran(names) => names.iter().map(String::as_str).collect(),
            Codels::Counts(counts) => counts.iter().map(|(name, _)| name.as_str()).collect(),
        };
        match wanted.into_iter().find(|name| !known.contains(name)) {
            None => Ok(()),
            Some(name) => {
                let help = suggest(name, known.iter().copied());
                Err(Why::unmet(
                    format!("a codel `{name}`"),
                    format!("{component} has none; {help}"),
                ))
            }
        }
    }
}

/// Names of all codels of a component.
fn names(of: &Description) -> Vec<&str> {
    let tasks = of.tasks.iter().flat_map(|task| &task.codels);
    let services = of.services.iter().flat_map(|one| one.codels.iter().chain(&one.validates));
    tasks.chain(services).map(|codel: &Codel| codel.name.as_str()).collect()
}

fn ran(codels: &Codels, counts: &BTreeMap<&str, u64>) -> Result<(), Why> {
    let count = |name: &str| counts.get(name).copied().unwrap_or(0);
    let (mut expected, mut came) = (Vec::new(), Vec::new());
    match codels {
        Codels::Ran(names) => {
            for name in names.iter().filter(|name| count(name) == 0) {
                expected.push(format!("{name} ran"));
                came.push("it did not".to_owned());
            }
        }
        Codels::Counts(wanted) => {
            for (name, wanted) in wanted.iter().filter(|(name, wanted)| count(name) != *wanted) {
                expected.push(format!("{name} = {wanted}"));
                came.push(format!("{name} = {}", count(name)));
            }
        }
    }
    match expected.is_empty() {
        true => Ok(()),
        false => Err(Why::unmet(expected.join(", "), came.join(", "))),
    }
}

fn compare(wanted: &Value, found: Option<&Value>, tolerance: f64) -> Result<(), Why> {
    let Some(found) = found else { return Err(Why::unmet(wanted.to_string(), "no value yet")) };
    let all = differences(wanted, found, tolerance);
    if all.is_empty() {
        return Ok(());
    }
    let (expected, came) = told(&all, tolerance);
    Err(Why::unmet(expected, came))
}

fn equal(wanted: Option<&u64>, found: &u64, what: &str) -> Result<(), Why> {
    match wanted.filter(|wanted| *wanted != found) {
        None => Ok(()),
        Some(wanted) => Err(Why::unmet(format!("{what} = {wanted}"), format!("{what} = {found}"))),
    }
}

/// States one after the other.
fn path(states: &[String]) -> String {
    match states.is_empty() {
        true => "no state".to_owned(),
        false => states.join(" > "),
    }
}
