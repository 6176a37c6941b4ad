//! `genomctl model`: the model of a component for other tools. Of files it takes no daemon.

use std::path::PathBuf;

use genom_export::{ExportError, Format, export, export_claim};
use genom_formal::{Bounds, System};

use super::verify::{Described, Given, Most, formulas};
use crate::failure::Failure;
use crate::session::Session;

/// Write what a component can do as a model for Spin, TChecker or UPPAAL, with the commands that
/// check it as comments at its head.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
promela and uppaal have the rules themselves, with clocks if all times are known; tchecker and \
uppaal-flat have the states that genomctl found, with clocks, and a location that is reached if one is \
missing. docs/verify.md says what can be asked of them.")]
pub(crate) struct Args {
    #[command(flatten)]
    described: Described,
    /// The language: promela, uppaal, tchecker or uppaal-flat.
    #[arg(long, value_parser = format)]
    format: Format,
    /// The file to write [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// With promela: this formula, as `genomctl verify --ltl` takes it, as the claim `user`.
    #[arg(long, value_name = "FORMULA")]
    ltl: Option<String>,
    #[command(flatten)]
    given: Given,
    /// Requests that clients make at the same time.
    #[arg(long, value_name = "N", default_value_t = 1)]
    requests: usize,
    /// Activities of one service that there are at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    instances: usize,
    #[command(flatten)]
    limits: Most,
}

fn format(name: &str) -> Result<Format, String> {
    let found = Format::ALL.into_iter().find(|format| format.name() == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
        format!("the languages are {}", names.join(", "))
    })
}

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let subjects = args.described.subjects(args.given.measured(), session).await?;
    let [subject] = &subjects[..] else {
        let message = "these files describe several components";
        return Err(Failure::usage(message, "name one with --component"));
    };
    args.given.check_names(&subjects)?;
    let times = args.given.times(subject).times;
    // With clocks it is the component while it serves requests, as in `verify`.
    let kill = times.is_err();
    let (requests, instances) = (args.requests, args.instances);
    let bounds = Bounds { requests, instances, kill, ..Bounds::default() };
    let system = System::new(&subject.plan, bounds);
    let formulas = formulas::read(args.ltl.as_slice(), &system)?;
    let text = match formulas.first() {
        Some(_) if args.format != Format::Promela => {
            return Err(Failure::usage("--ltl goes with --format promela", "claims are Spin's"));
        }
        Some(formula) => export_claim(&system, formula, times.as_ref().ok()),
        None => export(&system, args.format, times.as_ref().ok(), &args.limits.limits()),
    };
    let text = text.map_err(|error| {
        let message = match (&error, &times) {
            (ExportError::NoTimes, Err(why)) => format!("{}: {why}", args.format.name()),
            _ => error.to_string(),
        };
        Failure::refused("model", message)
    })?;
    match &args.output {
        Some(path) => std::fs::write(path, text).map_err(|error| Failure::file(path, error)),
        None => session.print(&text),
    }
}
