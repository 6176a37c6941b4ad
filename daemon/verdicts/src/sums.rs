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

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test code")]
mod tests {
    use std::sync::Arc;

    use genom_description::{Options, read_text};
    use genom_formal::{Bounds, Processors, System};
    use genom_runtime::Plan;

    #[test]
    fn a_bound_is_told_with_what_it_is_made_of_and_what_would_have_to_be_shorter() {
        let duo = "component duo { ids { long shared; };
          task fast { period 10 ms; priority 10; scheduling real-time;
            codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
          task slow { period 40 ms; priority 20; scheduling real-time;
            codel<start> sb(inout shared) yield work wcet 8 ms;
            codel<work> sw() yield pause::start wcet 20 ms; }; };";
        let options = Options { standard_interface: false, ..Options::default() };
        let plan = Plan::new(&Arc::new(read_text("duo.gen", duo, &options).specification), 0);
        let system = System::new(&Arc::new(plan.unwrap()), Bounds::default());
        assert_eq!(
            super::text(&system.schedule(&system.declared_times(), Processors::Own, 0)),
            "\
task fast (10.000 ms): MAY BE AT WORK AT ITS NEXT TICK
      3.000 ms  fa
      8.000 ms    after sb of slow
     11.000 ms  or more, and 10.000 ms are there
  in time if fa takes less than 2.000 ms
  in time if sb takes less than 7.000 ms
task slow (40.000 ms): in time, at most 31.000 ms from a tick to its end
      8.000 ms  sb
      3.000 ms    after fa of fast
     20.000 ms  sw
"
        );
    }
}
