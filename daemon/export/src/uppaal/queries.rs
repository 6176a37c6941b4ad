//! What is asked of a model: the properties of docs/verify.md.

use genom_formal::System;

use crate::tables::{executed, small};
use crate::xml::query;

pub(super) fn queries(text: &mut String, system: &System, timed: bool) {
    query(
        text,
        "A[] (deadlock imply (phase == RUNNING || phase == STOPPED))",
        "stuck: there is a next step until everything has ended; while requests are served, nobody has to \
         ask",
    );
    query(text, "A[] not together()", "exclude: what excludes each other is never executed");
    query(text, "E<> phase == RUNNING", "start: the start-up comes to its end");
    for (ix, codel) in system.plan().component().codels.pairs() {
        let executes = executed(system, ix);
        if !executes.is_empty() {
            let formula = format!("E<> ({})", executes.join(" || "));
            query(text, &formula, &format!("reach: codel {} can run", codel.name));
        }
    }
    for (service, at) in system.services().iter().zip(0u16..) {
        if service.builtin.is_none() {
            let comment = format!("reach: a request of {} can succeed", system.service_name(at));
            query(text, &format!("E<> pc[{at}] == CONCLUDE"), &comment);
        }
    }
    for task in (0..small(system.periods().len())).filter(|_| timed) {
        if system.periods()[usize::from(task)].is_some() {
            let formula = format!("A[] (works({task}) imply clk[{task}] < PERIOD[{task}])");
            let comment = format!("overrun: task {} is never late", system.task_name(task));
            query(text, &formula, &comment);
        }
    }
}
