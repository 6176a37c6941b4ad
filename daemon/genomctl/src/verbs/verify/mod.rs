//! `genomctl verify`: what a component can and cannot do, whatever its codels yield. Of files it takes
//! no daemon.

mod described;
pub(super) mod formulas;
mod given;
mod trace;

use std::path::PathBuf;

use genom_formal::{Formula, Property, System};
use genom_verdicts::rules::{self, Ruled};
use genom_verdicts::{Asked, Subject, Told};

pub(super) use self::described::{Described, ask, refused};
use self::given::Checked;
pub(super) use self::given::{Given, Most, most};
use crate::failure::Failure;
use crate::session::Session;

/// Check what a component can and cannot do, by its description: every order of events is tried,
/// whatever codels yield and clients ask. A component that runs is checked with its configuration.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Properties: start, stuck, reach, loop, stop, order, exclude and answer need no times; overrun and \
respond take the wcet of the description, or --wcet. respond is no verdict: it tells how long clients \
wait, by default if a first look finds it. docs/verify.md says what each means, what is assumed, and \
what formulas may say.

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
    /// Check this formula of linear temporal logic, too: '[] (run(go) -> <> !run(go))', '[]
    /// (codel(move) -> once codel(init))'; may be repeated. What is not of one of the forms in
    /// docs/verify.md takes Spin.
    #[arg(long, value_name = "FORMULA")]
    ltl: Vec<String>,
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

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let subjects = args.described.subjects(args.given.measured(), session).await?;
    args.given.check_names(&subjects)?;
    // Mistakes in the file come before anything is explored.
    let read = |file: &PathBuf| {
        Ruled::read(file, &subjects).map_err(|why| Failure::usage(why.to_string(), why.help()))
    };
    let ruled = args.config.as_ref().map(read).transpose()?;
    let bounds = |subject: &Subject| subject.bounds(args.requests, args.instances);
    let (asked, limits) = (asked(args), args.limits.limits());
    let formulas: Vec<Vec<Formula>> = subjects
        .iter()
        .map(|subject| formulas::read(&args.ltl, &System::new(&subject.plan, bounds(subject))))
        .collect::<Result<_, Failure>>()?;
    let check = |(subject, formulas): (Subject, Vec<Formula>)| {
        let (known, bounds) = (args.given.times(&subject), bounds(&subject));
        let mut told = Told::check(subject, &asked, known, bounds, &limits);
        let (system, times) = (&told.found.system, told.times.as_ref());
        told.found.report.formulas = formulas::check(formulas, system, times, &limits)?;
        Ok(told)
    };
    let all = subjects.into_iter().zip(formulas).map(check);
    let all: Vec<Told> = all.collect::<Result<_, Failure>>()?;
    let times = |subject: &Subject| args.given.times(subject).times;
    let judged = ruled.as_ref().map(|ruled| ruled.judge(&all, bounds, times, &limits));
    if session.json {
        let all = all.iter().map(|told| {
            let mut data = told.data();
            if let Some(judged) = &judged {
                data["rules"] = rules::data(judged, &told.subject);
            }
            data
        });
        let all: Vec<_> = all.collect();
        session.print(&format!("{}\n", serde_json::json!({ "components": all })))?;
    } else {
        let judged = judged.as_deref().unwrap_or_default();
        let all = all.iter().map(|told| told.text() + &rules::text(judged, &told.subject));
        let all: Vec<_> = all.collect();
        session.print(&all.join("\n"))?;
    }
    trace::write(&args.trace, &all, session)?;
    let violated: usize = all.iter().map(Told::violated).sum();
    let undecided: usize = all.iter().map(Told::undecided).sum();
    if violated + undecided == 0 { Ok(()) } else { Err(Failure::Verdict { violated, undecided }) }
}

/// All properties, or those that were named; none if only formulas are asked for.
fn asked(args: &Args) -> Asked {
    let all = args.property.is_empty() && args.ltl.is_empty();
    let named = |one: Checked| args.property.contains(&one);
    let asked = |one: Checked| all || named(one);
    let untimed = |property: &Property| asked(Checked::Untimed(*property));
    Asked {
        properties: Property::ALL.into_iter().filter(untimed).collect(),
        overrun: asked(Checked::Overrun),
        respond: asked(Checked::Respond).then(|| named(Checked::Respond)),
    }
}
