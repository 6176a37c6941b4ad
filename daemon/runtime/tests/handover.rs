//! An instance hands over to another one between two ticks.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::{Arc, Mutex};

use genom_runtime::{Clock, Frozen, Instance, NoRest, Resume, Resumed};
use support::closures::{Closures, Codel, LONG, codel, next, request, until};

const PERIOD: u64 = 2_000_000;

/// What a codel ran for: its instance, and the date.
type Ran = Arc<Mutex<Vec<(usize, u64)>>>;

fn body(number: usize, ran: &Ran, seen: &Ran) -> Arc<Closures> {
    let notes = |into: &Ran, event: &'static str| -> Codel {
        let into = Arc::clone(into);
        codel(move || {
            into.lock().unwrap().push((number, Clock::Monotonic.now()));
            event
        })
    };
    Closures::new(
        "component test {
           task t { period 2 ms; codel<start> begin() yield pause::main;
                    codel<main> tick() yield pause::main; };
           activity job() { task t; codel<start> work() yield pause::start, ether;
                            codel<stop> end() yield ether; };
         };",
        &[
            ("begin", codel(|| "pause::main")),
            ("tick", notes(ran, "pause::main")),
            ("work", notes(seen, "pause::start")),
            ("end", codel(|| "ether")),
        ],
    )
}

fn held() -> Resume {
    let (ports, executed, activities) = (Vec::new(), Vec::new(), Vec::new());
    Resume { ids: None, ports, executed, activities, hold: true }
}

/// As it was.
fn whole(frozen: Frozen) -> Resume {
    let one = |activity| Resumed { activity, reply: None, goes_on: true };
    Resume { activities: frozen.activities.into_iter().map(one).collect(), ..held() }
}

fn heir_of(instance: &Instance, body: &Arc<Closures>) -> Instance {
    body.start_with(|options| {
        options.resume = Some(held());
        options.epoch = Some(instance.epoch());
    })
}

#[test]
fn each_tick_is_served_once_by_one_of_the_two_and_an_activity_goes_on() {
    const TIMES: usize = 40;
    let (ran, seen) = (Ran::default(), Ran::default());
    let mut instance = body(0, &ran, &seen).start();
    let epoch = instance.epoch();
    let asked = request(&instance, "job");
    assert_eq!(next(&asked), "accepted 2");
    let mut missed = 0;
    for time in 1..=TIMES {
        let heir = heir_of(&instance, &body(time, &ran, &seen));
        let took: Result<Result<(), ()>, NoRest> =
            instance.hand_over(&heir, (LONG, LONG), |frozen, _| Ok(whole(frozen)), |_, _| {});
        assert_eq!(took, Ok(Ok(())));
        let by_heir = |ran: &Ran| ran.lock().unwrap().last().is_some_and(|last| last.0 == time);
        until("the next ticks are those of the heir", || by_heir(&ran) && by_heir(&seen));
        instance.finish_shutdown(std::time::Instant::now() + LONG).unwrap();
        missed += overruns(&instance);
        instance = heir;
        assert_eq!(asked.try_recv().ok(), None, "the client hears nothing");
    }
    let number = instance.activities().iter().find(|one| one.service.is_some()).unwrap().id;
    assert_eq!(number, 2);
    instance.abort(number).unwrap();
    assert_eq!(next(&asked), "done");
    instance.shutdown(LONG).unwrap();
    missed += overruns(&instance);
    let ran = ran.lock().unwrap();
    let order: Vec<usize> = ran.iter().map(|(number, _)| *number).collect();
    assert!(order.is_sorted(), "none runs before or after its time: {order:?}");
    let slots: Vec<u64> = ran.iter().map(|(_, date)| (date - epoch) / PERIOD).collect();
    let due = slots.last().unwrap() - slots.first().unwrap() + 1;
    let made = slots.len() as u64;
    assert!(made + missed >= due, "{made} of {due} ticks, {missed} were missed by themselves");
    assert!(made <= due + missed, "{made} of {due} ticks, {missed} were missed by themselves");
}

fn overruns(instance: &Instance) -> u64 {
    instance.statistics().tasks.iter().map(|task| task.overruns).sum()
}

#[test]
fn what_cannot_be_converted_stays_where_it_is_and_the_heir_is_held() {
    let (ran, seen) = (Ran::default(), Ran::default());
    let instance = body(0, &ran, &seen).start();
    let heir = heir_of(&instance, &body(1, &ran, &seen));
    let refused = instance.hand_over(&heir, (LONG, LONG), |_, _| Err("no"), |_, _| panic!("no"));
    assert_eq!(refused, Ok(Err("no")));
    let before = ran.lock().unwrap().len();
    until("it goes on", || ran.lock().unwrap().len() > before + 5);
    assert!(heir.is_held());
    assert!(ran.lock().unwrap().iter().all(|(number, _)| *number == 0));
    heir.shutdown(LONG).unwrap();
    instance.shutdown(LONG).unwrap();
}
