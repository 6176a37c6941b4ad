//! `genomctl verify`: what a component can and cannot do, whatever its codels yield. No daemon.

mod data;
mod described;
mod given;

use std::sync::Arc;

use genom_formal::{Bounds, Found, Property, System, Ticks, Verdict, text};
use genom_runtime::Plan;

pub(super) use self::described::Described;
use self::given::Checked;
pub(super) use self::given::{Given, Most, most};
use crate::failure::Failure;
use crate::session::Session;

/// Check what a component can and cannot do, by its description: every order of events is tried,
/// whatever codels yield and clients ask.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Properties: start, stuck, reach, loop, stop, order and exclude need no times; overrun takes the wcet \
of the description, or --wcet. docs/verify.md says what each means, and what is assumed.

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
    #[command(flatten)]
    limits: given::Most,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let (plans, sources) = args.described.plans()?;
    let found: Vec<_> = plans.iter().map(|plan| check(args, plan)).collect::<Result<_, _>>()?;
    if session.json {
        let all: Vec<_> = found.iter().map(|one| data::data(one, &sources)).collect();
        session.print(&format!("{}\n", serde_json::json!({ "components": all })))?;
    } else {
        let all: Vec<_> = found.iter().map(|one| text(one, &sources)).collect();
        session.print(&all.join("\n"))?;
    }
    verdict(&found)
}

fn check(args: &Args, plan: &Arc<Plan>) -> Result<Found, Failure> {
    let all = args.property.is_empty();
    let asked = |property: &Property| all || args.property.contains(&Checked::Untimed(*property));
    let properties: Vec<Property> = Property::ALL.into_iter().filter(asked).collect();
    let (requests, instances) = (args.requests, args.instances);
    let bounds = Bounds { requests, instances, ..Bounds::default() };
    let system = System::new(plan, bounds);
    let limits = args.limits.limits();
    let report = system.check(&properties, &limits);
    let ticks = if all || args.property.contains(&Checked::Overrun) {
        args.given.check(plan, bounds, &limits)?
    } else {
        Ticks::Unasked
    };
    Ok(Found { system, report, ticks })
}

fn verdict(found: &[Found]) -> Result<(), Failure> {
    let (mut violated, mut undecided) = (0, 0);
    for one in found {
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
