//! What `genomctl schedule` finds, as text.

use std::fmt::Write as _;

use genom_formal::{Called, Cause, Change, OnMachine, Schedule, Scheduled, duration};

/// The bounds of a component, and what they are made of.
#[must_use]
pub fn text(schedule: &Schedule) -> String {
    let mut text = String::new();
    schedule.tasks.iter().for_each(|one| task(&mut text, one));
    for other in &schedule.others {
        let _ = writeln!(text, "task {other}: no period, nothing is due");
    }
    text
}

/// The bound of one task of a machine, and what it is made of.
pub(crate) fn placed(placed: &OnMachine) -> String {
    let cpus: Vec<String> = placed.cpus.iter().map(usize::to_string).collect();
    let mut text = format!("{} on processor {}, ", placed.component, cpus.join(", "));
    task(&mut text, &placed.task);
    text
}

/// What would do, in a sentence.
pub(crate) fn change(change: &Change) -> String {
    match change {
        Change::Order(tasks) => {
            let order = tasks.join(", ");
            format!("all are in time with priorities in the order of periods: {order}")
        }
        Change::Processor { task, cpu } => {
            format!("all are in time with {task} on processor {cpu}")
        }
        Change::Time { codel, below, task } => {
            format!("{task} is in time if {codel} takes less than {}", duration(*below))
        }
    }
}

/// Why there is no bound, in a sentence.
pub(crate) fn cause(cause: &Cause) -> String {
    match cause {
        Cause::Late(_) => "MAY BE AT WORK AT ITS NEXT TICK".into(),
        Cause::Loop => "no bound: states follow each other in a circle without pause".into(),
        Cause::Preempted(task) => {
            format!("no bound: {task} has the same or a higher priority, and no bound itself")
        }
        Cause::NotRealTime(task) => {
            format!("no bound: {task} is not a real-time task, which others may hold up for long")
        }
    }
}

fn task(text: &mut String, task: &Scheduled) {
    let _ = write!(text, "task {} ({}): ", task.name, duration(task.period));
    let _ = match &task.response {
        Ok(response) => {
            writeln!(text, "in time, at most {} from a tick to its end", duration(*response))
        }
        Err(why) => writeln!(text, "{}", cause(why)),
    };
    for one in &task.called {
        called(text, one);
    }
    for one in &task.meanwhile {
        let all = duration(one.cycles.saturating_mul(one.each));
        let cycles = if one.cycles == 1 { "cycle" } else { "cycles" };
        let _ = writeln!(text, "  {all:>12}  waits for {} {cycles} of {}", one.cycles, one.of);
    }
    for (other, work) in &task.preempted_by {
        let _ = writeln!(text, "  {:>12}  for each cycle of task {other}", duration(*work));
    }
    if let Err(Cause::Late(least)) = &task.response {
        let _ = writeln!(text, "  {:>12}  or more, and {} are there", duration(*least), {
            duration(task.period)
        });
        for (codel, below) in &task.needed {
            let _ = writeln!(text, "  in time if {codel} takes less than {}", duration(*below));
        }
    }
}

fn called(text: &mut String, called: &Called) {
    let of = called.activity.as_ref().map_or_else(String::new, |name| format!(" of {name}"));
    let _ = writeln!(text, "  {:>12}  {}{of}", duration(called.most), called.codel);
    for waits in &called.waits {
        let of = format!("{} of {}", waits.codel, waits.of);
        let _ = writeln!(text, "  {:>12}    after {of}", duration(waits.most));
    }
}
