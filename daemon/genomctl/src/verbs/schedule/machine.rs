//! `--all`: the tasks of all components on the processors of one machine.

use std::num::NonZero;

use genom_formal::{Bounds, Machine, Placed, System, Threads};
use genom_protocol::routes;
use genom_verdicts::Subject;
use genom_verdicts::schedule::{Told, is_late};

use super::super::verify::{ask, refused};
use super::args::{Args, lateness};
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
    let (mut open, mut left_out, mut measured) = (0, Vec::new(), Vec::new());
    for one in &subjects {
        let known = args.given.times(one);
        let slots = one.running.as_ref().map_or(1, |running| running.max_activities);
        let bounds = Bounds { requests, instances: args.instances, slots, ..Bounds::default() };
        measured.extend(known.measured.map(|measured| (one.name().to_owned(), measured)));
        match (one.shares_its_thread(), known.times) {
            (None, Ok(times)) => systems.push((one, System::new(&one.plan, bounds), times)),
            (Some(why), _) | (None, Err(why)) => {
                open += 1;
                left_out.push((one.name().to_owned(), why));
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
    let told = Told { processors, tasks, changes, left_out, measured };
    if session.json {
        session.print(&format!("{}\n", told.data()))?;
    } else {
        session.print(&told.text())?;
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
                all.push(Subject::of_running(sources).map_err(refused)?);
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
