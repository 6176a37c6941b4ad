//! Steps of the virtual clock with requests of other threads at the same time.

#![allow(clippy::unwrap_used)]

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use genom_runtime::{Clock, Progress, VirtualClock, input_record};

use support::closures::{Closures, Codel, LONG};

#[test]
fn a_step_after_an_activity_was_accepted_runs_it_at_its_first_tick() {
    let clock = Arc::new(VirtualClock::new());
    let runs = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&runs);
    let begin: Codel = Arc::new(move || {
        counted.fetch_add(1, Ordering::Relaxed);
        "ether"
    });
    let body = Closures::new(
        "component test {
           task t { period 1 ms; };
           activity job() { task t; codel<start> begin() yield ether; };
         };",
        &[("begin", begin)],
    );
    let stepped = Arc::clone(&clock);
    let instance = body.start_with(|options| options.clock = Clock::Virtual(stepped));
    let (plan, job) = (instance.plan(), instance.plan().service("job").unwrap());
    let (stepper, steps) = channel();
    let others = Arc::clone(&clock);
    let reply = Box::new(move |progress| {
        if let Progress::Accepted { .. } = progress {
            // The client steps the clock as soon as it is informed, while this thread returns late.
            let (clock, (over, is_over)) = (Arc::clone(&others), channel());
            let step = thread::spawn(move || {
                clock.step(Duration::from_millis(1));
                let _ = over.send(());
            });
            let _ = is_over.recv_timeout(Duration::from_millis(200));
            stepper.send(step).unwrap();
        }
    });
    instance.request(job, input_record(plan, job).unwrap().unwrap(), reply);
    steps.recv_timeout(LONG).unwrap().join().unwrap();
    assert_eq!(clock.now(), 1_000_000);
    assert_eq!(runs.load(Ordering::Relaxed), 1, "it ran at the tick of that step");
    instance.shutdown(LONG).unwrap();
}
