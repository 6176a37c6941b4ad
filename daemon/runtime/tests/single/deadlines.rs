//! The order in which the shared thread does what is due.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use genom_allocations as allocations;

use crate::support::closures::{Closures, Codel, LONG, codel, gate, next, request, until};
use crate::support::{shared, start_on};

/// Notes the names of codels in the order of their calls, while told to.
#[derive(Default)]
struct Notes {
    on: AtomicBool,
    calls: Mutex<Vec<&'static str>>,
}

impl Notes {
    fn codel(self: &Arc<Self>, name: &'static str) -> Codel {
        let notes = Arc::clone(self);
        codel(move || {
            if notes.on.load(Ordering::SeqCst) {
                notes.calls.lock().unwrap().push(name);
            }
            "pause::start"
        })
    }
}

#[test]
fn of_ticks_that_wait_the_one_with_the_earliest_deadline_is_served_first() {
    let (executor, notes) = (shared(), Arc::new(Notes::default()));
    // Declared and started in the opposite order.
    let slow = Closures::new(
        "component test {
           task slow { period 160 ms; codel<start> slow() yield pause::start; };
           task middle { period 40 ms; codel<start> middle() yield pause::start; };
         };",
        &[("slow", notes.codel("slow")), ("middle", notes.codel("middle"))],
    );
    let quick = Closures::new(
        "component test {
           task quick { period 10 ms; codel<start> quick() yield pause::start; };
         };",
        &[("quick", notes.codel("quick"))],
    );
    let (gate, keeper) = gate();
    let holder = Closures::new(
        "component test { function hold() { codel hold(); }; };",
        &[(
            "hold",
            codel(move || {
                gate.pass();
                "ok"
            }),
        )],
    );
    let instances = [
        start_on(&executor, "slow", &slow),
        start_on(&executor, "quick", &quick),
        start_on(&executor, "holder", &holder),
    ];
    let held = request(&instances[2], "hold");
    keeper.wait();
    // A tick of each task comes meanwhile. The deadline of the first one of a shorter period is at
    // most two periods away, that of a longer one at least one.
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_millis(200) {
        std::thread::park_timeout(Duration::from_millis(10));
    }
    notes.on.store(true, Ordering::SeqCst);
    keeper.let_one_pass();
    assert_eq!(next(&held), "done");
    let firsts = || {
        let mut firsts: Vec<&str> = Vec::new();
        for name in notes.calls.lock().unwrap().iter() {
            if !firsts.contains(name) {
                firsts.push(name);
            }
        }
        firsts
    };
    until("each was served", || firsts().len() == 3);
    assert_eq!(firsts(), ["quick", "middle", "slow"]);
    instances.iter().for_each(|instance| instance.shutdown(LONG).unwrap());
}

#[test]
fn ticks_of_one_period_are_served_together_in_the_order_of_start_and_declaration() {
    let (executor, notes) = (shared(), Arc::new(Notes::default()));
    let body = |[one, other]: [&'static str; 2]| {
        Closures::new(
            "component test {
               task one { period 20 ms; codel<start> a() yield pause::start; };
               task other { period 20 ms; codel<start> b() yield pause::start; };
             };",
            &[("a", notes.codel(one)), ("b", notes.codel(other))],
        )
    };
    let bodies = [body(["0 one", "0 other"]), body(["1 one", "1 other"])];
    // Started at different moments of their period.
    let first = start_on(&executor, "first", &bodies[0]);
    std::thread::park_timeout(Duration::from_millis(7));
    let second = start_on(&executor, "second", &bodies[1]);
    notes.on.store(true, Ordering::SeqCst);
    until("they ticked", || notes.calls.lock().unwrap().len() >= 40);
    notes.on.store(false, Ordering::SeqCst);
    let calls = notes.calls.lock().unwrap().clone();
    let begin = calls.iter().position(|name| *name == "0 one").unwrap();
    for round in calls[begin..].chunks_exact(4) {
        assert_eq!(round, ["0 one", "0 other", "1 one", "1 other"], "{calls:?}");
    }
    first.shutdown(LONG).unwrap();
    second.shutdown(LONG).unwrap();
}

#[test]
fn ticks_are_at_multiples_of_the_period_so_that_those_served_and_missed_are_all_that_passed() {
    let executor = shared();
    let calls = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&calls);
    let body = Closures::new(
        "component test { task t { period 1 ms; codel<start> c() yield pause::start; }; };",
        &[(
            "c",
            codel(move || {
                counted.fetch_add(1, Ordering::SeqCst);
                "pause::start"
            }),
        )],
    );
    let instance = start_on(&executor, "test", &body);
    let served = || calls.load(Ordering::SeqCst) + instance.statistics().tasks[0].overruns;
    let (begin, before) = (Instant::now(), served());
    until("500 ticks", || calls.load(Ordering::SeqCst) >= 500);
    let earliest = served() - before;
    let passed = u64::try_from(begin.elapsed().as_millis()).unwrap();
    // A period that began late and was not caught up with would lose ticks.
    assert!(earliest <= passed + 2, "{earliest} ticks in {passed} ms");
    let later = served() - before;
    assert!(later + 2 >= passed, "{later} ticks in {passed} ms");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_task_that_never_pauses_keeps_neither_ticks_nor_requests_from_being_served() {
    let executor = shared();
    let spins = Closures::new(
        "component test {
           task t { };
           task p { period 1 ms; };
           activity job() { task t; codel<start> work() yield start, ether; };
           activity tick() { task p; codel<start> on_time() yield start, ether; };
         };",
        &[("work", codel(|| "start")), ("on_time", codel(|| "start"))],
    );
    let (sender, ticks) = channel();
    let sender = Mutex::new(sender);
    let other = Closures::new(
        "component test {
           task t { period 10 ms; codel<start> c() yield pause::start; };
           function f() { codel g(); };
         };",
        &[(
            "c",
            codel(move || {
                let _ = sender.lock().unwrap().send(());
                "pause::start"
            }),
        )],
    );
    let instances = [start_on(&executor, "spins", &spins), start_on(&executor, "other", &other)];
    let jobs = [request(&instances[0], "job"), request(&instances[0], "tick")];
    jobs.iter().for_each(|job| assert!(next(job).starts_with("accepted")));
    (0..10).for_each(|_| ticks.recv_timeout(LONG).unwrap());
    assert_eq!(next(&request(&instances[1], "f")), "done");
    assert_eq!(instances[0].abort_all().len(), 2);
    instances.iter().for_each(|instance| instance.shutdown(LONG).unwrap());
}

#[test]
fn ticks_on_a_shared_thread_allocate_nothing() {
    const WARM: u64 = 100;
    const TICKS: u64 = 5_000;
    let executor = shared();
    // The state ports are written every second, between ticks, and that allocates.
    let all: Arc<OnceLock<Vec<Arc<Closures>>>> = Arc::default();
    let written = {
        let all = Arc::clone(&all);
        move || all.get().into_iter().flatten().map(|one| one.states.load(Ordering::SeqCst)).sum()
    };
    let (sender, counted) = channel();
    let state = Mutex::new((0u64, 0u64, 0u64, 0u64));
    let counts = codel(move || {
        let mut state = state.lock().unwrap();
        let (ticks, allocated, last, states) = &mut *state;
        let (now, writes): (u64, u64) = (allocations::count(), written());
        if writes == *states && *ticks >= WARM {
            *allocated += now - *last;
        }
        *ticks += u64::from(writes == *states);
        if *ticks == WARM + TICKS {
            let _ = sender.send(*allocated);
        }
        (*last, *states) = (allocations::count(), writes);
        "pause::start"
    });
    let body = |tick: Codel| {
        Closures::new(
            "component test {
               ids { long a; };
               task t { period 100 us; codel<start> tick(inout a) yield pause::start; };
               task u { period 300 us; codel<start> two() yield main;
                        codel<main> more() yield pause::start; };
             };",
            &[("tick", tick), ("two", codel(|| "main")), ("more", codel(|| "pause::start"))],
        )
    };
    let mut bodies: Vec<_> = (0..8).map(|_| body(codel(|| "pause::start"))).collect();
    bodies.push(body(counts));
    assert!(all.set(bodies.clone()).is_ok());
    let instances: Vec<_> = bodies.iter().map(|body| start_on(&executor, "one", body)).collect();
    assert_eq!(counted.recv_timeout(LONG).unwrap(), 0);
    instances.iter().for_each(|instance| instance.shutdown(LONG).unwrap());
}

#[test]
fn on_an_overloaded_thread_instances_stop_before_others_make_many_passes() {
    const EACH: u64 = 10;
    let (executor, passes) = (shared(), Arc::new(AtomicU64::new(0)));
    let counted = Arc::clone(&passes);
    // Twice as much as there is time for: a tick is always late.
    let busy = codel(move || {
        counted.fetch_add(1, Ordering::SeqCst);
        let end = Instant::now() + Duration::from_millis(2);
        while Instant::now() < end {}
        "pause::start"
    });
    let busy = Closures::new(
        "component test { task t { period 1 ms; codel<start> busy() yield pause::start; }; };",
        &[("busy", busy)],
    );
    let quiet = || {
        Closures::new(
            "component test {
               task t { period 500 ms; codel<start> idle() yield pause::start; };
             };",
            &[("idle", codel(|| "pause::start"))],
        )
    };
    let busy = start_on(&executor, "busy", &busy);
    let names: Vec<String> = (0..EACH).map(|number| format!("quiet{number}")).collect();
    let all: Vec<_> = names.iter().map(|name| start_on(&executor, name, &quiet())).collect();
    let before = passes.load(Ordering::SeqCst);
    for instance in all {
        instance.shutdown(LONG).unwrap();
    }
    // Each stop takes a few turns of control, and none of them waits for more than one pass.
    let each = (passes.load(Ordering::SeqCst) - before) / EACH;
    assert!(each <= 5, "{each} passes for each");
    busy.shutdown(LONG).unwrap();
}
