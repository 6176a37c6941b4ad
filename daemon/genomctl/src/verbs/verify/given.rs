//! What the command line asks for: properties, times and limits.

use std::time;

use genom_description::model::Component;
use genom_formal::{Duration, Limits, Property, Times};
use genom_verdicts::{Known, Measured, Subject};

use crate::failure::Failure;

/// What can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Checked {
    /// Whatever time codels take.
    Untimed(Property),
    /// Every cycle ends before the next tick.
    Overrun,
    /// How long clients of activities wait.
    Respond,
}

/// A property by its name.
pub(super) fn property(name: &str) -> Result<Checked, String> {
    let untimed = Property::ALL.into_iter().find(|property| property.name() == name);
    match untimed {
        Some(property) => Ok(Checked::Untimed(property)),
        None if name == "overrun" => Ok(Checked::Overrun),
        None if name == "respond" => Ok(Checked::Respond),
        None => {
            let names: Vec<&str> = Property::ALL.iter().map(|property| property.name()).collect();
            Err(format!("the properties are {}, overrun, respond", names.join(", ")))
        }
    }
}

/// Times of codels.
#[derive(Debug, clap::Args)]
pub(in crate::verbs) struct Given {
    /// Time that a codel takes at most, in milliseconds, or from a least to a greatest one:
    /// demo_servo=0.2, demo_servo=0.1..0.2; may be repeated.
    #[arg(long, value_name = "CODEL=TIME", value_parser = codel_time)]
    wcet: Vec<(String, Duration)>,
    /// Time that codels take at most of which it is not known otherwise, in milliseconds.
    #[arg(long, value_name = "TIME", value_parser = most)]
    other_wcet: Option<u64>,
    /// Of a component that runs: take as least times the shortest ones measured, and for codels
    /// without wcet the longest ones, if they ran at least 1000 times.
    #[arg(long)]
    measured: bool,
    /// What the longest time measured is multiplied by.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.2, requires = "measured", value_parser = margin)]
    margin: f64,
}

/// A factor that makes a time no shorter.
fn margin(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|_| "a number is wanted".to_owned())?;
    if (1.0..=1000.0).contains(&factor) { Ok(factor) } else { Err("from 1 to 1000".to_owned()) }
}

/// Limits of the search.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(in crate::verbs) struct Most {
    /// States to look at, at most.
    #[arg(long, value_name = "N", default_value_t = 5_000_000)]
    states: usize,
    /// Memory for states, at most, in MiB.
    #[arg(long, value_name = "MIB", default_value_t = 1024)]
    memory: usize,
    /// Time for each search, at most, in seconds.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = crate::times::seconds)]
    time: time::Duration,
}

impl Most {
    pub(in crate::verbs) fn limits(self) -> Limits {
        Limits { states: self.states, memory: self.memory.saturating_mul(1 << 20), time: self.time }
    }
}

/// Milliseconds as nanoseconds.
pub(in crate::verbs) fn most(text: &str) -> Result<u64, String> {
    let ms: f64 = text.parse().map_err(|_| "a number of milliseconds is wanted".to_owned())?;
    let duration = time::Duration::try_from_secs_f64(ms / 1e3).map_err(|e| e.to_string())?;
    Ok(genom_runtime::nanos(duration))
}

/// `CODEL=MOST` or `CODEL=LEAST..MOST`.
pub(super) fn codel_time(text: &str) -> Result<(String, Duration), String> {
    let (codel, time) = text.split_once('=').ok_or("write CODEL=TIME")?;
    let (least, greatest) = match time.split_once("..") {
        Some((least, greatest)) => (most(least)?, most(greatest)?),
        None => (0, most(time)?),
    };
    if least > greatest {
        return Err("the first time is longer than the second".into());
    }
    Ok((codel.to_owned(), Duration { least, most: Some(greatest) }))
}

impl Given {
    /// Whether measured times are asked for.
    pub(in crate::verbs) fn measured(&self) -> bool {
        self.measured
    }

    /// Checks that each codel that is named is one of these components.
    pub(in crate::verbs) fn check_names(&self, subjects: &[Subject]) -> Result<(), Failure> {
        for (name, _) in &self.wcet {
            let has =
                |one: &Subject| one.plan.component().codels.iter().any(|codel| codel.name == *name);
            if !subjects.iter().any(has) {
                let names: Vec<&str> = subjects.iter().map(Subject::name).collect();
                let message = format!("{} has no codel `{name}`", names.join(", "));
                return Err(Failure::usage(message, "name a codel of the description"));
            }
        }
        Ok(())
    }

    /// The times of all codels, or which have no bound; and what was measured.
    pub(in crate::verbs) fn times(&self, subject: &Subject) -> Known {
        let component = subject.plan.component();
        let mut times = Times::declared(component);
        let measured = subject
            .measured
            .as_ref()
            .map(|statistics| Measured::take(&mut times, component, statistics, self.margin));
        Known { times: self.given(component, times), measured }
    }

    /// What is given takes precedence.
    fn given(&self, component: &Component, mut times: Times) -> Result<Times, String> {
        for (codel, duration) in &self.wcet {
            times.set(component, codel, *duration);
        }
        if let Some(others) = self.other_wcet {
            times.bound_others(others);
        }
        let unbounded = times.unbounded(component);
        let Some((last, first)) = unbounded.split_last() else { return Ok(times) };
        let names = if first.is_empty() {
            format!("{last} has")
        } else {
            format!("{} and {last} have", first.join(", "))
        };
        let way = match self.measured {
            true => "give --wcet or --other-wcet, or let it run longer",
            false => "declare it, or give --wcet or --other-wcet",
        };
        Err(format!("{names} no wcet: {way}"))
    }
}
