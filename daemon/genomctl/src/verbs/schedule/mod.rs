//! `genomctl schedule`: how long the cycles of tasks may take, from sums. Of files it takes no daemon.

mod args;
mod machine;

use genom_formal::{Bounds, Processors, System};
use genom_verdicts::{Measured, schedule, sums};
use serde_json::json;

pub(crate) use self::args::Args;
use self::args::lateness;
use crate::failure::Failure;
use crate::session::Session;

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
        let found = match (subject.shares_its_thread(), known.times) {
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
        late += found.tasks.iter().filter(|task| schedule::is_late(task)).count();
        open += found
            .tasks
            .iter()
            .filter(|task| task.response.is_err() && !schedule::is_late(task))
            .count();
        let mut data = schedule::data(name, &found);
        if let Some(measured) = &known.measured {
            data["measured"] = measured.data();
        }
        all.push((format!("{heading}{}", sums::text(&found)), data));
    }
    let (texts, data): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    if session.json {
        session.print(&format!("{}\n", json!({ "components": data })))?;
    } else {
        session.print(&texts.join("\n"))?;
    }
    if late + open == 0 { Ok(()) } else { Err(Failure::Late { late, open }) }
}
