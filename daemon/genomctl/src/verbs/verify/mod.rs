//! `genomctl verify`: what a component can and cannot do, whatever its codels yield. Of files it takes
//! no daemon.

mod data;
mod described;
mod given;
mod loaded;
mod measured;
mod ruled;
mod trace;

use std::path::PathBuf;

use genom_formal::{Bounds, Found, Property, System, Ticks, Times, Verdict, text};
use serde_json::Value;

pub(super) use self::described::{Described, Subject, ask};
use self::given::Checked;
pub(super) use self::given::{Given, Most, most};
pub(super) use self::loaded::{shares_its_thread, subject};
pub(super) use self::measured::Measured;
use crate::failure::Failure;
use crate::session::Session;

/// Check what a component can and cannot do, by its description: every order of events is tried,
/// whatever codels yield and clients ask. A component that runs is checked with its configuration.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Properties: start, stuck, reach, loop, stop, order and exclude need no times; overrun takes the wcet \
of the description, or --wcet. docs/verify.md says what each means, and what is assumed.

With --config, rules of supervision are told as `cannot fire` (no run breaks it), `can fire` (with a \
shortest run), `always fires` (its bound or order is wrong) or `not decided`. They do not change the \
exit status.

Exit status: 0 all hold; 1 one is violated; 4 none is violated, but one is not decided.")]
pub(crate) struct Args {
    #[command(flatten)]
    described: Described,
    /// Check this property only; may be repeated [default: all].
    #[arg(long, value_name = "NAME", value_parser = given::property)]
    property: Vec<Checked>,
    #[command(flatten)]
    given: Given,
    /// Requests that clients make at the same time.
    #[arg(long, value_name = "N", default_value_t = 1)]
    requests: usize,
    /// Activities of one service that there are at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    instances: usize,
    /// Also say of each rule that this configuration or deployment file has for the component
    /// ([[component.supervision]]) whether it can be broken.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    limits: given::Most,
    /// Write runs in which tasks are late into a file, by its ending: .mcap, a recording of the first
    /// one, for Foxglove; or .toml, scenarios that `genomctl test` plays on the runtime without the
    /// library. May be repeated.
    #[arg(long, value_name = "FILE", value_parser = trace::file)]
    trace: Vec<PathBuf>,
}

impl Args {
    /// What clients may do of a component.
    fn bounds(&self, subject: &Subject) -> Bounds {
        let (requests, instances) = (self.requests, self.instances);
        let mut bounds = Bounds { requests, instances, ..Bounds::default() };
        if let Some(running) = &subject.running {
            bounds.slots = running.max_activities;
        }
        bounds
    }
}

/// What was found of one component.
struct Told {
    subject: Subject,
    found: Found,
    measured: Option<Measured>,
    /// The times of its codels, if all are known.
    times: Option<Times>,
}

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let subjects = args.described.subjects(args.given.measured(), session).await?;
    args.given.check_names(&subjects)?;
    // Mistakes in the file come before anything is explored.
    let read = |file: &PathBuf| ruled::Ruled::read(file, &subjects);
    let ruled = args.config.as_ref().map(read).transpose()?;
    let all: Vec<Told> = subjects.into_iter().map(|subject| check(args, subject)).collect();
    let judged = ruled.as_ref().map(|ruled| ruled.judge(args, &all)).unwrap_or_default();
    if session.json {
        let all = all.iter().map(|told| {
            let mut data = json(told);
            if ruled.is_some() {
                data["rules"] = ruled::data(&judged, &told.subject);
            }
            data
        });
        let all: Vec<_> = all.collect();
        session.print(&format!("{}\n", serde_json::json!({ "components": all })))?;
    } else {
        let all = all.iter().map(|told| people(told) + &ruled::text(&judged, &told.subject));
        let all: Vec<_> = all.collect();
        session.print(&all.join("\n"))?;
    }
    trace::write(&args.trace, &all, session)?;
    verdict(&all)
}

fn check(args: &Args, subject: Subject) -> Told {
    let all = args.property.is_empty();
    let asked = |property: &Property| all || args.property.contains(&Checked::Untimed(*property));
    let properties: Vec<Property> = Property::ALL.into_iter().filter(asked).collect();
    let bounds = args.bounds(&subject);
    let system = System::new(&subject.plan, bounds);
    let limits = args.limits.limits();
    let report = system.check(&properties, &limits);
    let known = args.given.times(&subject);
    let times = known.times.clone().ok();
    let ticks = if all || args.property.contains(&Checked::Overrun) {
        Given::check(&subject, known.times, bounds, &limits)
    } else {
        Ticks::Unasked
    };
    Told { subject, found: Found { system, report, ticks }, measured: known.measured, times }
}

fn people(told: &Told) -> String {
    let measured = told.measured.as_ref().map_or_else(String::new, Measured::text);
    format!("{}{measured}{}", told.subject.heading(), text(&told.found, &told.subject.texts))
}

fn json(told: &Told) -> Value {
    let mut data = data::data(&told.found, &told.subject.texts);
    if let Some(running) = &told.subject.running {
        data["instance"] = running.name.clone().into();
        data["settings"] = serde_json::json!(running.tasks);
    }
    if let Some(measured) = &told.measured {
        data["measured"] = measured.data();
    }
    data
}

fn verdict(all: &[Told]) -> Result<(), Failure> {
    let (mut violated, mut undecided) = (0, 0);
    for Told { found: one, measured, .. } in all {
        violated += measured.as_ref().map_or(0, Measured::violated);
        for (_, verdict) in &one.report.verdicts {
            violated += usize::from(matches!(verdict, Verdict::Violated(_)));
            undecided += usize::from(matches!(verdict, Verdict::Undecided(_)));
        }
        match &one.ticks {
            Ticks::Seen(times) => {
                violated += times.tasks.iter().filter(|task| task.is_late()).count();
                undecided += times.tasks.iter().filter(|task| task.is_open()).count();
            }
            Ticks::Unknown(_) => undecided += 1,
            Ticks::Unasked => {}
        }
    }
    if violated + undecided == 0 { Ok(()) } else { Err(Failure::Verdict { violated, undecided }) }
}
