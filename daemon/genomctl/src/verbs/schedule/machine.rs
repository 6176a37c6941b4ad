//! `--all`: the tasks of all components on the processors of one machine.

use std::num::NonZero;

use genom_formal::{Bounds, Cause, Change, Machine, OnMachine, Placed, System, Threads};
use genom_protocol::routes;
use serde_json::{Value, json};

use super::super::verify::{Measured, Subject, ask, shares_its_thread, subject};
use super::{Args, is_late, lateness, task};
use crate::apart::Genomd;
use crate::failure::Failure;
use crate::session::Session;

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let subjects = subjects(args, session).await?;
    args.given.check_names(&subjects)?;
    let here = || std::thread::available_parallelism().map_or(1, NonZero::get);
    let given = args.processors.map(|count| usize::try_from(count).unwrap_or(usize::MAX));
    let processors = given.unwrap_or_else(here);
    let requests = args.requests.unwrap_or(usize::MAX);
    let mut systems = Vec::new();
    let (mut open, mut told, mut measured) = (0, Vec::new(), Vec::new());
    for one in &subjects {
        let known = args.given.times(one);
        let slots = one.running.as_ref().map_or(1, |running| running.max_activities);
        let bounds = Bounds { requests, instances: args.instances, slots, ..Bounds::default() };
        measured.extend(known.measured.map(|measured| (one.name().to_owned(), measured)));
        match (shares_its_thread(one), known.times) {
            (None, Ok(times)) => systems.push((one, System::new(&one.plan, bounds), times)),
            (Some(why), _) | (None, Err(why)) => {
                open += 1;
                told.push((one.name().to_owned(), why));
            }
        }
    }
    let placed = systems.iter().map(|(one, system, times)| Placed {
        name: one.name().to_owned(),
        system,
        times: times.clone(),
        threads: threads(args, one),
    });
    let machine = Machine { processors, components: placed.collect() };
    // What has no bound may take the processors for any time: it is said, and the others are told
    // as if it were not there.
    let (tasks, changes) = (machine.schedule(), machine.changes());
    let late = tasks.iter().filter(|one| is_late(&one.task)).count();
    open += tasks.iter().filter(|one| one.task.response.is_err() && !is_late(&one.task)).count();
    if session.json {
        let data = data(processors, &tasks, &changes, &told, &measured);
        session.print(&format!("{data}\n"))?;
    } else {
        session.print(&text(processors, &tasks, &changes, &told, &measured))?;
    }
    if late + open == 0 { Ok(()) } else { Err(Failure::Late { late, open }) }
}

/// The components of the file, or those of the daemon.
async fn subjects(args: &Args, session: &Session) -> Result<Vec<Subject>, Failure> {
    let mut all = Vec::new();
    match args.described.named() {
        [] => {
            for component in session.ask(routes::components()).await?.content.components {
                all.push(ask(&component.name, args.given.measured(), session).await?);
            }
        }
        [file] if !args.given.measured() => {
            for sources in Genomd::new(None).sources(file)? {
                let read = subject(sources);
                all.push(read.map_err(|why| Failure::refused("sources", why.to_string()))?);
            }
        }
        [_] => {
            let message = "nothing was measured of a file";
            return Err(Failure::usage(message, "without a file, --all takes what runs"));
        }
        _ => {
            let message = "--all takes one deployment file";
            return Err(Failure::usage(message, "without a file it takes what runs"));
        }
    }
    if all.is_empty() {
        return Err(Failure::usage("there is no component", "load one, or name a deployment file"));
    }
    Ok(all)
}

fn threads(args: &Args, subject: &Subject) -> Vec<Threads> {
    let tasks = subject.running.iter().flat_map(|running| &running.tasks);
    let late = lateness(args, subject);
    tasks.map(|task| Threads { cpus: task.cpus.clone(), late }).collect()
}

fn text(
    processors: usize,
    tasks: &[OnMachine],
    changes: &[Change],
    told: &[(String, String)],
    measured: &[(String, Measured)],
) -> String {
    let mut text = String::new();
    for (name, measured) in measured {
        text.push_str(&format!("{name}, measured:\n{}", measured.text()));
    }
    text.push_str(&format!("{processors} processors\n"));
    for one in tasks {
        text.push_str(&one.text());
    }
    for (name, why) in told {
        text.push_str(&format!(
            "{name}: no bound: {why}; the others are told as if it were not there\n"
        ));
    }
    for change in changes {
        text.push_str(&format!("{}\n", change.text()));
    }
    text
}

fn data(
    processors: usize,
    tasks: &[OnMachine],
    changes: &[Change],
    told: &[(String, String)],
    measured: &[(String, Measured)],
) -> Value {
    let one = |one: &OnMachine| {
        let mut data = task(&one.task);
        data["component"] = one.component.clone().into();
        data["cpus"] = json!(one.cpus);
        data["late"] = matches!(one.task.response, Err(Cause::Late(_))).into();
        data
    };
    let left_out = |(name, why): &(String, String)| json!({ "component": name, "why": why });
    let codels =
        |(name, one): &(String, Measured)| json!({ "component": name, "codels": one.data() });
    json!({
        "processors": processors,
        "tasks": tasks.iter().map(one).collect::<Vec<_>>(),
        "left_out": told.iter().map(left_out).collect::<Vec<_>>(),
        "changes": changes.iter().map(change).collect::<Vec<_>>(),
        "measured": measured.iter().map(codels).collect::<Vec<_>>(),
    })
}

fn change(change: &Change) -> Value {
    match change {
        Change::Order(tasks) => json!({ "priorities": tasks }),
        Change::Processor { task, cpu } => json!({ "task": task, "cpu": cpu }),
        Change::Time { codel, below, task } => {
            json!({ "codel": codel, "below_ns": below, "task": task })
        }
    }
}
