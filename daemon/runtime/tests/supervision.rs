//! Rules that components are supervised by: what breaks them, what is told, and what it costs those
//! that keep them: nothing.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use genom_runtime::{
    Change, Clock, CodelIx, Execution, Executor, Instance, Options, Rule, Supervised, Violation,
    VirtualClock, Watcher,
};
use support::closures::{Closures, Codel, Keeper, LONG, codel, gate, next, request, until};

/// Keeps what is told.
#[derive(Default)]
struct Told(Mutex<Vec<Violation>>);

impl Watcher for Told {
    fn changed(&self, change: &Change) {
        if let Change::Violated(violation) = change {
            self.0.lock().unwrap().push(violation.clone());
        }
    }
}

impl Told {
    fn all(&self) -> Vec<Violation> {
        self.0.lock().unwrap().clone()
    }
}

const MS: Duration = Duration::from_millis(1);

/// A component that all tests share.
const GEN: &str = "component test {
    ids { long a; };
    task t { period 10 ms; codel<start> tick(inout a) yield pause::start; };
    task free { };
    function calibrate() { codel zero(); };
    function move() { codel go(); };
    activity spin() { task t; codel<start> round() yield start, ether;
                      codel<stop> halt() yield ether; };
    activity long_one() { task t; codel<start> wait() yield main;
                          codel<main> rest() yield pause::main, ether; };
    activity hang() { task free; codel<start> stay() yield ether; };
};";

/// The codels of a name.
fn codels(body: &Closures, name: &str) -> Vec<CodelIx> {
    let codels = body.plan.component().codels.pairs();
    codels.filter_map(|(ix, codel)| (codel.name == name).then_some(ix)).collect()
}

fn longest(body: &Closures, name: &str, longest: Duration) -> Rule {
    Rule::Longest { codels: codels(body, name).into_iter().map(|ix| (ix, longest)).collect() }
}

/// A component with these rules; those in `interrupts` interrupt.
fn start(
    body: &Arc<Closures>,
    rules: Vec<Rule>,
    interrupts: bool,
    change: impl FnOnce(&mut Options),
) -> (Instance, Arc<Told>) {
    let told = Arc::new(Told::default());
    let watcher = Arc::clone(&told);
    let instance = body.start_with(|options| {
        options.watcher = Some(watcher);
        let rules = rules.into_iter().map(|rule| Supervised { rule, interrupts });
        options.rules = rules.collect();
        change(options);
    });
    (instance, told)
}

fn stepped(body: &Arc<Closures>, rules: Vec<Rule>) -> (Instance, Arc<Told>, Arc<VirtualClock>) {
    let clock = Arc::new(VirtualClock::new());
    let stepped = Arc::clone(&clock);
    let (instance, told) =
        start(body, rules, true, |options| options.clock = Clock::Virtual(stepped));
    (instance, told, clock)
}

fn events(of: &[(&'static str, &'static str)]) -> Vec<(&'static str, Codel)> {
    of.iter().map(|&(name, event)| (name, codel(move || event))).collect()
}

const ORDINARY: [(&str, &str); 6] = [
    ("tick", "pause::start"),
    ("round", "start"),
    ("halt", "ether"),
    ("wait", "main"),
    ("rest", "pause::main"),
    ("stay", "ether"),
];

#[test]
fn a_task_that_misses_ticks_within_a_window_is_told_and_its_activities_stop_at_the_same_step_each_time()
 {
    let run = || {
        let body = Closures::new(GEN, &events(&ORDINARY));
        let task = body.plan.component().tasks.find(|task| task.name == "t").unwrap();
        let rule = Rule::Missed { task, ticks: 3, within: Duration::from_millis(50) };
        let (instance, told, clock) = stepped(&body, vec![rule]);
        let spin = request(&instance, "spin");
        clock.step(Duration::from_millis(100));
        assert_eq!(next(&spin), "accepted 3");
        // Its codel of state `stop` ended it.
        assert_eq!(next(&spin), "done");
        assert_eq!(instance.violations(), [1]);
        instance.shutdown(LONG).unwrap();
        told.all()
    };
    let first = run();
    assert_eq!(first.len(), 1);
    assert_eq!((first[0].what.as_str(), first[0].count), ("task t missed 3 ticks", 1));
    assert_eq!(first, run());
}

#[test]
fn an_activity_over_its_time_is_told_as_soon_as_it_is_once_and_asked_to_stop() {
    let body = Closures::new(GEN, &events(&ORDINARY));
    let service = body.plan.service("long_one").unwrap();
    let rule = Rule::Activity { service, longest: Duration::from_millis(25) };
    let (instance, told, clock) = stepped(&body, vec![rule]);
    let long = request(&instance, "long_one");
    clock.step(Duration::from_millis(24));
    assert_eq!(told.all(), []);
    clock.step(Duration::from_millis(100));
    next(&long);
    assert_eq!(next(&long), "::genom::interrupted {\"by\":\"supervision\"}");
    let all = told.all();
    assert_eq!(all.len(), 1);
    assert_eq!((all[0].date, all[0].activity), (25_000_001, Some(3)));
    assert_eq!(all[0].what, "activity long_one has taken 25.0 ms");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn an_activity_that_ends_in_time_breaks_no_rule() {
    let body = Closures::new(GEN, &events(&[("tick", "pause::start"), ("round", "ether")]));
    let service = body.plan.service("spin").unwrap();
    let rule = Rule::Activity { service, longest: Duration::from_millis(10) };
    let (instance, told, clock) = stepped(&body, vec![rule]);
    let brief = request(&instance, "spin");
    clock.step(Duration::from_millis(100));
    next(&brief);
    assert_eq!(next(&brief), "done");
    assert_eq!(told.all(), []);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn orders_that_must_not_happen_are_told_when_they_do() {
    let body = Closures::new(GEN, &events(&ORDINARY));
    let service = body.plan.service("long_one").unwrap();
    let (owner, states) = (body.plan.component().services[service].clone(), body.plan.component());
    assert_eq!(owner.name, "long_one");
    let state = |name| states.state(name).unwrap();
    let rules = vec![
        Rule::After { codels: codels(&body, "go"), first: codels(&body, "zero") },
        Rule::During { codels: codels(&body, "go"), service },
        Rule::Step {
            owner: genom_description::model::Owner::Service(service),
            from: state("start"),
            to: state("main"),
        },
    ];
    let (instance, told, clock) = stepped(&body, rules);
    let done = |service| assert_eq!(next(&request(&instance, service)), "done");
    done("move");
    done("calibrate");
    done("move");
    assert_eq!(instance.violations(), [1, 0, 0]);
    let long = request(&instance, "long_one");
    clock.step(Duration::from_millis(20));
    next(&long);
    // It was interrupted, since it took the forbidden step, and `stop` has no codel.
    assert_eq!(next(&long), "::genom::interrupted {\"by\":\"supervision\"}");
    assert_eq!(instance.violations(), [1, 0, 1]);
    let (all, what) = (told.all(), ["codel go of move was called before codel zero"]);
    assert_eq!(all[0].what, what[0]);
    assert_eq!(all[1].what, "it went from start to main");
    done("move");
    assert_eq!(instance.violations(), [1, 0, 1], "nothing runs any more");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_codel_that_must_not_be_called_while_an_activity_runs_is_told_only_then() {
    let body = Closures::new(GEN, &events(&ORDINARY));
    let service = body.plan.service("long_one").unwrap();
    let rule = Rule::During { codels: codels(&body, "go"), service };
    let (instance, told, clock) = stepped(&body, vec![rule]);
    let done = |service| assert_eq!(next(&request(&instance, service)), "done");
    let long = request(&instance, "long_one");
    done("move");
    assert_eq!(instance.violations(), [0], "it was accepted, and does not run yet");
    clock.step(Duration::from_millis(20));
    done("move");
    assert_eq!(instance.violations(), [1]);
    instance.abort(3).unwrap();
    clock.step(Duration::from_millis(20));
    assert!(next(&long).starts_with("accepted") && next(&long).contains("client"));
    done("move");
    assert_eq!(instance.violations(), [1]);
    clock.step(Duration::ZERO);
    assert_eq!(told.all()[0].what, "codel go of move was called while activity long_one ran");
    instance.shutdown(LONG).unwrap();
}

/// A codel that takes two milliseconds.
fn slow(event: &'static str) -> Codel {
    codel(move || {
        let end = Instant::now() + 2 * MS;
        while Instant::now() < end {}
        event
    })
}

#[test]
fn a_codel_that_returns_too_late_is_told_with_its_activity_which_is_interrupted() {
    let mut all = events(&ORDINARY);
    all.retain(|(name, _)| *name != "rest");
    all.push(("rest", slow("pause::main")));
    let body = Closures::new(GEN, &all);
    let (instance, told) = start(&body, vec![longest(&body, "rest", MS)], true, |_| {});
    let long = request(&instance, "long_one");
    assert_eq!(next(&long), "accepted 3");
    assert_eq!(next(&long), "::genom::interrupted {\"by\":\"supervision\"}");
    until("it is told", || !told.all().is_empty());
    let first = told.all()[0].clone();
    assert_eq!((first.activity, first.thread), (Some(3), None));
    assert!(first.what.starts_with("codel rest of long_one took "), "{}", first.what);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_codel_of_a_request_is_supervised_as_well() {
    let body = Closures::new(GEN, &[("tick", codel(|| "pause::start")), ("go", slow("ok"))]);
    let (instance, told) = start(&body, vec![longest(&body, "go", MS)], false, |_| {});
    assert_eq!(next(&request(&instance, "move")), "done");
    until("it is told", || !told.all().is_empty());
    assert_eq!((instance.violations(), told.all()[0].activity), (vec![1], None));
    instance.shutdown(LONG).unwrap();
}

/// A component in whose codel `stay` somebody waits.
fn hanging() -> (Arc<Closures>, Keeper) {
    let (gate, keeper) = gate();
    let mut all = events(&ORDINARY);
    all.retain(|(name, _)| *name != "stay");
    all.push((
        "stay",
        codel(move || {
            gate.pass();
            "ether"
        }),
    ));
    (Closures::new(GEN, &all), keeper)
}

#[test]
fn a_codel_that_does_not_return_is_told_once_by_who_watches_and_not_again_when_it_returns() {
    let (body, keeper) = hanging();
    let rules = vec![
        longest(&body, "stay", MS),
        Rule::Stuck { codels: body.plan.component().codels.places().collect() },
    ];
    let (instance, told) = start(&body, rules, true, |options| {
        options.stuck_after = Duration::from_millis(5);
    });
    let hang = request(&instance, "hang");
    keeper.wait();
    until("both are told", || {
        let again = instance.supervise();
        assert!(again.is_some_and(|again| again <= Duration::from_millis(250)));
        instance.violations() == [1, 1]
    });
    let first = told.all()[0].clone();
    assert!(first.what.starts_with("codel stay of hang has not returned for "), "{}", first.what);
    assert!(first.thread.is_some() && first.activity == Some(3));
    instance.supervise();
    keeper.let_one_pass();
    assert!(next(&hang).starts_with("accepted"));
    assert_eq!(next(&hang), "done");
    instance.supervise();
    assert_eq!(instance.violations(), [1, 1]);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn on_a_stepped_clock_a_codel_takes_no_time_but_one_that_is_stuck_is_told() {
    let (body, keeper) = hanging();
    let (instance, _, clock) = stepped(&body, vec![longest(&body, "stay", MS)]);
    let _hang = request(&instance, "hang");
    thread::scope(|scope| {
        scope.spawn(|| clock.step(MS));
        keeper.wait();
        until("it has run for longer", || {
            instance.supervise();
            instance.running_codels().iter().any(|codel| codel.for_ns > 20_000_000)
        });
        keeper.let_one_pass();
    });
    assert_eq!(instance.violations(), [0]);
    instance.shutdown(LONG).unwrap();

    let (body, keeper) = hanging();
    let clock = Arc::new(VirtualClock::new());
    let own = Arc::clone(&clock);
    let rule = vec![longest(&body, "stay", MS)];
    let (instance, told) = start(&body, rule, false, |options| {
        options.clock = Clock::Virtual(own);
        options.stuck_after = 5 * MS;
    });
    let _hang = request(&instance, "hang");
    thread::scope(|scope| {
        scope.spawn(|| clock.step(MS));
        keeper.wait();
        until("it is told", || {
            instance.supervise();
            !told.all().is_empty()
        });
        keeper.let_one_pass();
    });
    instance.shutdown(LONG).unwrap();
}

#[test]
fn ticks_that_are_missed_while_a_codel_does_not_return_are_told_before_it_returns() {
    let (gate, keeper) = gate();
    let tick = codel(move || {
        gate.pass();
        "pause::start"
    });
    let body = Closures::new(GEN, &[("tick", tick)]);
    keeper.let_one_pass();
    let task = body.plan.component().tasks.find(|task| task.name == "t").unwrap();
    let rule = Rule::Missed { task, ticks: 3, within: LONG };
    let (instance, told) = start(&body, vec![rule], false, |_| {});
    keeper.wait();
    keeper.wait();
    until("it is told", || {
        instance.supervise();
        !told.all().is_empty()
    });
    keeper.let_one_pass();
    drop(keeper);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn the_rounds_of_a_shared_thread_stand_still_while_a_codel_does_not_return() {
    let (body, keeper) = hanging();
    let executor = Arc::new(Executor::new("tasks"));
    assert_eq!(executor.rounds(), None);
    let own = Arc::clone(&executor);
    let (instance, told) = start(&body, vec![longest(&body, "stay", MS)], false, |options| {
        options.execution = Execution::Single(own);
    });
    let goes_on = || {
        let before = executor.rounds();
        executor.wake();
        until("it goes on", || executor.rounds() > before);
    };
    goes_on();
    let _hang = request(&instance, "hang");
    keeper.wait();
    let before = executor.rounds();
    until("it is told", || {
        executor.wake();
        instance.supervise();
        !told.all().is_empty()
    });
    assert_eq!(executor.rounds(), before);
    keeper.let_one_pass();
    goes_on();
    instance.shutdown(LONG).unwrap();
}
