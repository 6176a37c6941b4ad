//! `genomctl schedule`: how long the cycles of tasks may take, from sums. No daemon.

use genom_formal::{Bounds, Cause, Processors, Schedule, Scheduled, System};
use serde_json::{Value, json};

use super::verify::{Described, Given};
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
    #[command(flatten)]
    given: Given,
    /// Processors that the tasks share, by priority [default: one for each thread].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
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

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let (plans, _) = args.described.plans()?;
    let requests = args.requests.unwrap_or(usize::MAX);
    let bounds = Bounds { requests, instances: args.instances, ..Bounds::default() };
    let processors = args.processors.map_or(Processors::Own, Processors::Shared);
    let (mut late, mut open, mut all) = (0, 0, Vec::new());
    for plan in &plans {
        let name = &plan.component().name;
        let found = match args.given.times(plan)? {
            Ok(times) => System::new(plan, bounds).schedule(&times, processors, args.lateness),
            Err(why) => {
                open += 1;
                all.push((
                    format!("component {name}\nno bound: {why}\n"),
                    json!({
                        "component": name, "tasks": null, "why": why,
                    }),
                ));
                continue;
            }
        };
        let is_late = |task: &&Scheduled| matches!(task.response, Err(Cause::Late(_)));
        late += found.tasks.iter().filter(is_late).count();
        open += found.tasks.iter().filter(|task| task.response.is_err() && !is_late(task)).count();
        all.push((format!("component {name}\n{}", found.text()), data(name, &found)));
    }
    let (texts, data): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    if session.json {
        session.print(&format!("{}\n", json!({ "components": data })))?;
    } else {
        session.print(&texts.join("\n"))?;
    }
    if late + open == 0 { Ok(()) } else { Err(Failure::Late { late, open }) }
}

fn data(name: &str, schedule: &Schedule) -> Value {
    let pairs = |key: &str, value: &str, all: &[(String, u64)]| {
        let one = |(name, ns): &(String, u64)| json!({ key: name, value: ns });
        all.iter().map(one).collect::<Vec<_>>()
    };
    let task = |task: &Scheduled| {
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
    };
    let tasks: Vec<Value> = schedule.tasks.iter().map(task).collect();
    json!({ "component": name, "tasks": tasks, "without_period": schedule.others })
}
