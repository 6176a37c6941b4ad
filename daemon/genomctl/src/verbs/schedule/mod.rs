//! `genomctl schedule`: how long the cycles of tasks may take, from sums. Of files it takes no daemon.

mod machine;

use genom_formal::{Bounds, Cause, Processors, Schedule, Scheduled, System};
use serde_json::{Value, json};

use super::verify::{Described, Given, Measured, Subject, shares_its_thread};
use crate::failure::Failure;
use crate::session::Session;

/// Tell how long the cycles of tasks may take: which codels, what each may wait for, and what would
/// have to be shorter.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The bounds are safe for any number of requests, and found at once; exact ones are found by \
`genomctl verify --property overrun`. docs/verify.md has the formulas, and what is assumed.

Exit status: 0 all tasks are in time; 1 one may not be; 4 none may be late, but one has no bound.")]
pub(crate) struct Args {
    #[command(flatten)]
    described: Described,
    /// All components of the daemon, or of a deployment file (TOML), on the processors of one
    /// machine, with the priorities and processors that are configured.
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    given: Given,
    /// Processors that the tasks share, by priority [default: one for each thread; with --all those
    /// of this machine].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    processors: Option<u64>,
    /// How late cycles begin, in milliseconds: `max` of lateness in `genomctl stats`.
    #[arg(long, value_name = "TIME", value_parser = super::verify::most, default_value = "0")]
    lateness: u64,
    /// Requests that clients make at the same time [default: one of each service].
    #[arg(long, value_name = "N")]
    requests: Option<usize>,
    /// Activities of one service that there are at the same time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    instances: usize,
}

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    if args.all {
        return machine::run(args, session).await;
    }
    let subjects = args.described.subjects(args.given.measured(), session).await?;
    args.given.check_names(&subjects)?;
    let requests = args.requests.unwrap_or(usize::MAX);
    let bounds = Bounds { requests, instances: args.instances, ..Bounds::default() };
    let processors = args.processors.map_or(Processors::Own, Processors::Shared);
    let (mut late, mut open, mut all) = (0, 0, Vec::new());
    for subject in &subjects {
        let slots = subject.running.as_ref().map_or(bounds.slots, |one| one.max_activities);
        let bounds = Bounds { slots, ..bounds };
        let name = subject.name();
        let known = args.given.times(subject);
        let measured = known.measured.as_ref().map_or_else(String::new, Measured::text);
        let heading = format!("{}{measured}component {name}\n", subject.heading());
        let found = match (shares_its_thread(subject), known.times) {
            (None, Ok(times)) => {
                let system = System::new(&subject.plan, bounds);
                system.schedule(&times, processors, lateness(args, subject))
            }
            (Some(why), _) | (None, Err(why)) => {
                open += 1;
                let data = json!({ "component": name, "tasks": null, "why": why });
                all.push((format!("{heading}no bound: {why}\n"), data));
                continue;
            }
        };
        late += found.tasks.iter().filter(|task| is_late(task)).count();
        open += found.tasks.iter().filter(|task| task.response.is_err() && !is_late(task)).count();
        let mut data = data(name, &found);
        if let Some(measured) = &known.measured {
            data["measured"] = measured.data();
        }
        all.push((format!("{heading}{}", found.text()), data));
    }
    let (texts, data): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    if session.json {
        session.print(&format!("{}\n", json!({ "components": data })))?;
    } else {
        session.print(&texts.join("\n"))?;
    }
    if late + open == 0 { Ok(()) } else { Err(Failure::Late { late, open }) }
}

fn is_late(task: &Scheduled) -> bool {
    matches!(task.response, Err(Cause::Late(_)))
}

/// How late cycles of a component begin: what is given, and no less than what was measured.
fn lateness(args: &Args, subject: &Subject) -> u64 {
    let measured = subject.measured.iter().flat_map(|statistics| &statistics.tasks);
    measured.map(|task| task.lateness.max_ns).chain([args.lateness]).max().unwrap_or(0)
}

fn data(name: &str, schedule: &Schedule) -> Value {
    let tasks: Vec<Value> = schedule.tasks.iter().map(task).collect();
    json!({ "component": name, "tasks": tasks, "without_period": schedule.others })
}

fn task(task: &Scheduled) -> Value {
    let pairs = |key: &str, value: &str, all: &[(String, u64)]| {
        let one = |(name, ns): &(String, u64)| json!({ key: name, value: ns });
        all.iter().map(one).collect::<Vec<_>>()
    };
    let called = task.called.iter().map(|called| {
        let waits = called.waits.iter();
        let waits =
            waits.map(|one| json!({ "of": one.of, "codel": one.codel, "most_ns": one.most }));
        json!({
            "codel": called.codel, "activity": called.activity, "most_ns": called.most,
            "waits": waits.collect::<Vec<_>>(),
        })
    });
    json!({
        "task": task.name,
        "period_ns": task.period,
        "response_ns": task.response.as_ref().ok(),
        "why": task.response.as_ref().err().map(Cause::text),
        "work_ns": task.work,
        "called": called.collect::<Vec<_>>(),
        "preempted_by": pairs("task", "work_ns", &task.preempted_by),
        "needed": pairs("codel", "below_ns", &task.needed),
    })
}
