//! Activities that never pause: what is reported while they run.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use genom_runtime::{Instance, Unpaused};
use support::closures::{Closures, Codel, LONG, next, request, until};

/// A component whose activity `job` yields `main` without pause until it may end.
struct Spinning {
    instance: Instance,
    steps: Arc<AtomicU64>,
    over: Arc<AtomicBool>,
}

impl Spinning {
    fn start(period: &str) -> Self {
        let (steps, over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (counted, may_end) = (Arc::clone(&steps), Arc::clone(&over));
        let spin: Codel = Arc::new(move || {
            counted.fetch_add(1, Ordering::Relaxed);
            if may_end.load(Ordering::Relaxed) { "ether" } else { "main" }
        });
        let begin: Codel = Arc::new(|| "main");
        let body = Closures::new(
            &format!(
                "component test {{
                   task t {{ {period} }};
                   activity job() {{ task t; codel<start> begin() yield main;
                                     codel<main> spin() yield main, ether; }};
                 }};"
            ),
            &[("begin", begin), ("spin", spin)],
        );
        let instance = body.start_with(|options| options.stuck_after = Duration::from_millis(50));
        Self { instance, steps, over }
    }

    fn unpaused(&self) -> Option<Unpaused> {
        self.instance.statistics().tasks[0].unpaused.clone()
    }
}

#[track_caller]
fn is_told_while_it_lasts(period: &str) {
    let spinning = Spinning::start(period);
    let job = request(&spinning.instance, "job");
    until("it spins", || spinning.steps.load(Ordering::Relaxed) > 0);
    let cycles = || spinning.instance.statistics().tasks[0].cycles;
    let first = cycles();
    assert!(first.count > 0, "{first:?}");
    let longer = first.max_ns + 20_000_000;
    until("the cycle that lasts grows", || cycles().max_ns >= longer);
    until("it is told", || spinning.unpaused().is_some());
    let told = spinning.unpaused().unwrap();
    assert_eq!((told.codel.as_str(), told.owner.as_str()), ("spin", "job"));
    assert_eq!((told.task.as_str(), told.periodic), ("t", !period.is_empty()));
    assert!(told.for_ns > 50_000_000 && told.steps > 0, "{told:?}");
    assert!(told.thread.is_some());
    assert_eq!(spinning.instance.unpaused().len(), 1);
    assert_eq!(spinning.instance.stuck(), None, "each of its codels returns");
    spinning.over.store(true, Ordering::Relaxed);
    assert_eq!([next(&job), next(&job)], ["accepted 2", "done"]);
    until("it pauses again", || spinning.unpaused().is_none());
    assert!(cycles().max_ns >= longer, "it is one of those that are over");
    spinning.instance.shutdown(LONG).unwrap();
    let last = cycles();
    std::thread::park_timeout(Duration::from_millis(20));
    assert_eq!(cycles(), last, "nothing lasts any more");
}

#[test]
fn an_activity_that_never_pauses_is_told_while_it_lasts() {
    is_told_while_it_lasts("");
}

#[test]
fn one_of_a_periodic_task_is_told_while_it_lasts() {
    is_told_while_it_lasts("period 5 ms;");
}

#[test]
fn a_shutdown_ends_one_that_never_pauses() {
    let spinning = Spinning::start("");
    let job = request(&spinning.instance, "job");
    until("it spins", || spinning.steps.load(Ordering::Relaxed) > 0);
    spinning.instance.shutdown(LONG).unwrap();
    assert_eq!([next(&job).as_str(), next(&job).as_str()][0], "accepted 2");
    assert!(spinning.unpaused().is_none());
}
