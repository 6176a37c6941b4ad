//! What was found of one component, for people and as JSON.

use genom_formal::{Bounds, Limits, Property, System, TimedReport, Times, Verdict};
use serde_json::{Value, json};

use crate::data;
use crate::found::{Found, Ticks};
use crate::measured::Measured;
use crate::subject::Subject;
use crate::text::text;

/// What is known of the times of a component.
#[derive(Debug)]
pub struct Known {
    /// Those of all codels; or which have no bound.
    pub times: Result<Times, String>,
    /// What was measured, if that was asked for.
    pub measured: Option<Measured>,
}

/// What is looked at.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Properties that need no times.
    pub properties: Vec<Property>,
    /// Whether cycles end before the next tick.
    pub overrun: bool,
    /// How long clients wait: whether that is asked for by its name, and so within the limits; else
    /// it is told if a first look finds it.
    pub respond: Option<bool>,
}

/// What was found of one component.
pub struct Told {
    /// The component.
    pub subject: Subject,
    /// The verdicts.
    pub found: Found,
    /// What was measured of it, if that was asked for.
    pub measured: Option<Measured>,
    /// The times of its codels, if all are known.
    pub times: Option<Times>,
}

impl Told {
    /// Looks at all that is asked.
    #[must_use]
    pub fn check(
        subject: Subject,
        asked: &Asked,
        known: Known,
        bounds: Bounds,
        limits: &Limits,
    ) -> Self {
        let system = System::new(&subject.plan, bounds);
        let report = system.check(&asked.properties, limits);
        let times = known.times.clone().ok();
        let ticks = match asked.overrun || asked.respond.is_some() {
            true => ticks(&subject, asked, known.times, (bounds, limits)),
            false => Ticks::Unasked,
        };
        Self { subject, found: Found { system, report, ticks }, measured: known.measured, times }
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let measured = self.measured.as_ref().map_or_else(String::new, Measured::text);
        let found = text(&self.found, &self.subject.texts);
        format!("{}{measured}{found}", self.subject.heading())
    }

    /// The same as JSON.
    #[must_use]
    pub fn data(&self) -> Value {
        let mut data = data::data(&self.found, &self.subject.texts);
        if let Some(running) = &self.subject.running {
            data["instance"] = running.name.clone().into();
            data["settings"] = json!(running.tasks);
        }
        if let Some(measured) = &self.measured {
            data["measured"] = measured.data();
        }
        data
    }

    /// What was found of properties without times, and of formulas.
    fn untimed(&self) -> impl Iterator<Item = &Verdict> {
        let report = &self.found.report;
        let formulas = report.formulas.iter().map(|(_, verdict)| verdict);
        report.verdicts.iter().map(|(_, verdict)| verdict).chain(formulas)
    }

    /// Properties that are violated.
    #[must_use]
    pub fn violated(&self) -> usize {
        let untimed = self.untimed().filter(|one| matches!(one, Verdict::Violated(_))).count();
        let late = match &self.found.ticks {
            Ticks::Seen(times) => times.tasks.iter().filter(|task| task.is_late()).count(),
            Ticks::Unknown(..) | Ticks::Unasked => 0,
        };
        self.measured.as_ref().map_or(0, Measured::violated) + untimed + late
    }

    /// Properties that are not decided.
    #[must_use]
    pub fn undecided(&self) -> usize {
        let untimed = self.untimed().filter(|one| matches!(one, Verdict::Undecided(_))).count();
        untimed
            + match &self.found.ticks {
                Ticks::Seen(times) => times.tasks.iter().filter(|task| task.is_open()).count(),
                Ticks::Unknown(..) => 1,
                Ticks::Unasked => 0,
            }
    }
}

/// Looks at what takes times; tells why not if that cannot be done.
fn ticks(
    subject: &Subject,
    asked: &Asked,
    times: Result<Times, String>,
    (bounds, limits): (Bounds, &Limits),
) -> Ticks {
    let times = match (subject.shares_its_thread(), times) {
        (Some(why), _) | (None, Err(why)) => {
            return Ticks::Unknown(if asked.overrun { "overrun" } else { "respond" }, why);
        }
        (None, Ok(times)) => times,
    };
    // What is measured is the component while it serves requests.
    let system = System::new(&subject.plan, Bounds { kill: false, ..bounds });
    let mut report = match asked.overrun {
        true => system.check_ticks(&times, limits),
        false => TimedReport::default(),
    };
    if let Some(by_name) = asked.respond {
        let limits = if by_name { *limits } else { limits.first() };
        report.responses = system.respond(&times, &limits);
    }
    Ticks::Seen(Box::new(report))
}
