//! Cycles without pause in periodic tasks.

use crate::{accepted, analyse, warned};

/// An activity of a task, with a stop codel.
fn activity(task: &str, codels: &str) -> String {
    format!(
        "component c {{ task t {{ {task} }}; activity a() {{ task t; {codels}
         codel<stop> z() yield ether; }}; }};"
    )
}

const PERIODIC: &str = "period 5 ms;";

#[test]
fn a_cycle_of_a_periodic_task_that_nothing_leads_out_of_is_told() {
    let text = activity(PERIODIC, "codel<start> x() yield start;");
    let codes: Vec<_> = analyse(&text).diagnostics.iter().map(|one| one.code).collect();
    assert_eq!(codes, ["W0901", "W0950"]);
    // The codels of a task are checked as well.
    warned("W0950", "component c { task t { period 5 ms; codel<start> x() yield start; }; };");
}

#[test]
fn a_cycle_of_a_periodic_task_that_only_ends_by_itself_is_told() {
    warned("W0951", &activity(PERIODIC, "codel<start> x() yield start, ether;"));
    let two = "codel<start> x() yield main; codel<main> y() yield more;
               codel<more> w() yield main, ether;";
    warned("W0951", &activity(PERIODIC, two));
    let said = analyse(&activity(PERIODIC, two)).diagnostics[0].clone();
    assert_eq!(said.message, "states `main`, `more` follow each other without a pause");
    assert!(
        said.help.unwrap().starts_with("task `t` misses its ticks until a codel yields `ether`")
    );
}

#[test]
fn a_cycle_that_may_pause_or_has_no_period_to_miss_is_no_mistake() {
    accepted(&activity(PERIODIC, "codel<start> x() yield pause::start, ether;"));
    accepted(&activity(PERIODIC, "codel<start> x() yield start, pause::start, ether;"));
    let through = "codel<start> x() yield main; codel<main> y() yield pause::start, ether;";
    accepted(&activity(PERIODIC, through));
    // Not reported: a driver that waits for data in its codel.
    accepted(&activity("", "codel<start> x() yield start, ether;"));
    accepted(&activity(PERIODIC, "codel<start> x() yield main; codel<main> y() yield ether;"));
}
