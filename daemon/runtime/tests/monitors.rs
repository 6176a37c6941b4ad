//! Cycles, stops, heartbeats, orders and formulas: what breaks them, and at which date that is told.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use genom_runtime::{
    Beats, Bounds, Change, Clock, CodelIx, Happening, Instance, Order, Part, Program, Rule,
    ServiceIx, Supervised, Violation, VirtualClock, Watcher,
};
use support::closures::{Closures, Codel, LONG, codel, gate, next, request, until};

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

    /// Dates in milliseconds, and what was told.
    fn lines(&self) -> Vec<String> {
        let line = |one: &Violation| format!("{} ms: {}", one.date / 1_000_000, one.what);
        self.all().iter().map(line).collect()
    }
}

const MS: Duration = Duration::from_millis(1);
const ANY: Bounds = Bounds { least: 0, most: u64::MAX };

const GEN: &str = "component test {
    ids { long a; };
    typedef long place;
    port out place pose;
    task t { period 10 ms; codel<start> tick(inout a) yield pause::start; };
    task free { };
    function calibrate() { codel zero(); };
    function move() { codel go(); };
    activity round() { task t; codel<start> turn(out pose) yield pause::start, ether;
                       codel<stop> linger() yield pause::stop, ether; };
    activity hang() { task free; codel<start> stay() yield ether; };
};";

fn codels(body: &Closures, name: &str) -> Vec<CodelIx> {
    let codels = body.plan.component().codels.pairs();
    codels.filter_map(|(ix, codel)| (codel.name == name).then_some(ix)).collect()
}

fn calls(body: &Closures, name: &str) -> Vec<Happening> {
    codels(body, name).into_iter().map(Happening::Call).collect()
}

fn service(body: &Closures, name: &str) -> ServiceIx {
    body.plan.service(name).unwrap()
}

fn program(parts: Vec<(Part, &str)>) -> Rule {
    let parts = parts.into_iter().map(|(part, text)| (part, text.to_owned())).collect();
    Rule::Formula(Program::new(parts).unwrap())
}

fn component(change: &[(&'static str, Codel)]) -> Arc<Closures> {
    let ordinary = [
        ("tick", "pause::start"),
        ("turn", "pause::start"),
        ("linger", "ether"),
        ("stay", "ether"),
    ];
    let mut all: Vec<(&'static str, Codel)> = change.to_vec();
    for (name, event) in ordinary {
        if !change.iter().any(|(other, _)| *other == name) {
            all.push((name, codel(move || event)));
        }
    }
    Closures::new(GEN, &all)
}

fn stepped(
    body: &Arc<Closures>,
    rules: Vec<Rule>,
    interrupts: bool,
) -> (Instance, Arc<Told>, Arc<VirtualClock>) {
    let (clock, told) = (Arc::new(VirtualClock::new()), Arc::new(Told::default()));
    let (own, watcher) = (Arc::clone(&clock), Arc::clone(&told));
    let instance = body.start_with(|options| {
        options.watcher = Some(watcher);
        options.clock = Clock::Virtual(own);
        options.rules = rules.into_iter().map(|rule| Supervised { rule, interrupts }).collect();
    });
    (instance, told, clock)
}

fn threads(body: &Arc<Closures>, rules: Vec<Rule>) -> (Instance, Arc<Told>) {
    let told = Arc::new(Told::default());
    let watcher = Arc::clone(&told);
    let instance = body.start_with(|options| {
        options.watcher = Some(watcher);
        let rules = rules.into_iter().map(|rule| Supervised { rule, interrupts: false });
        options.rules = rules.collect();
    });
    (instance, told)
}

#[test]
fn a_cycle_that_takes_longer_is_told_with_its_time_and_its_bound() {
    let slow = codel(|| {
        let end = Instant::now() + 2 * MS;
        while Instant::now() < end {}
        "pause::start"
    });
    let body = component(&[("tick", slow)]);
    let task = body.plan.component().tasks.find(|task| task.name == "t").unwrap();
    let rules = vec![Rule::Cycle { task, longest: MS }, Rule::Cycle { task, longest: LONG }];
    let (instance, told) = threads(&body, rules);
    until("it is told", || !told.all().is_empty());
    let first = told.all()[0].clone();
    assert!(first.what.starts_with("a cycle of task t took "), "{}", first.what);
    assert!(first.value.unwrap() > 1_000_000 && first.bound == Some(1_000_000));
    assert_eq!(instance.violations()[1], 0);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_cycle_that_does_not_end_is_told_by_who_watches_once_and_not_again_when_it_ends() {
    let (gate, keeper) = gate();
    let body = component(&[(
        "stay",
        codel(move || {
            gate.pass();
            "ether"
        }),
    )]);
    let task = body.plan.component().tasks.find(|task| task.name == "free").unwrap();
    let (instance, told) = threads(&body, vec![Rule::Cycle { task, longest: 300 * MS }]);
    let hang = request(&instance, "hang");
    keeper.wait();
    until("it is told", || {
        instance.supervise();
        !told.all().is_empty()
    });
    assert!(told.all()[0].what.starts_with("a cycle of task free has taken "));
    keeper.let_one_pass();
    assert!(next(&hang).starts_with("accepted"));
    assert_eq!(next(&hang), "done");
    instance.shutdown(LONG).unwrap();
    assert_eq!(told.all().len(), 1);
}

#[test]
fn an_activity_that_takes_longer_to_stop_is_told_as_soon_as_it_does() {
    let over = Arc::new(AtomicBool::new(false));
    let ends = Arc::clone(&over);
    let linger = codel(move || if ends.load(Ordering::SeqCst) { "ether" } else { "pause::stop" });
    let body = component(&[("linger", linger)]);
    let rule = Rule::Stop { service: service(&body, "round"), longest: Duration::from_millis(25) };
    let (instance, told, clock) = stepped(&body, vec![rule], false);
    let round = request(&instance, "round");
    clock.step(Duration::from_millis(100));
    assert_eq!(next(&round), "accepted 3");
    assert_eq!(told.lines(), [""; 0], "it was not asked to stop");
    instance.abort(3).unwrap();
    clock.step(Duration::from_millis(24));
    assert_eq!(told.lines(), [""; 0]);
    clock.step(Duration::from_millis(76));
    assert_eq!(told.lines(), ["125 ms: activity round was asked to stop 25.0 ms ago"]);
    assert_eq!((told.all()[0].value, told.all()[0].bound), (Some(25_000_001), Some(25_000_000)));
    assert_eq!(instance.violations(), [1]);
    over.store(true, Ordering::SeqCst);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn heartbeats_of_a_codel_that_come_too_early_or_too_late_are_told_and_others_are_not() {
    let body = component(&[]);
    let beat = |least, longest| Rule::Beat {
        of: Beats::Codels(codels(&body, "tick")),
        least: least * MS,
        longest: longest * MS,
        during: None,
    };
    let (instance, told, clock) =
        stepped(&body, vec![beat(10, 11), beat(12, 50), beat(0, 7)], false);
    clock.step(Duration::from_millis(35));
    // It is called at 10, 20 and 30; the call of the start-up does not count.
    assert_eq!(instance.violations(), [0, 2, 3]);
    assert_eq!(
        told.lines()[..3],
        [
            "7 ms: codel tick was not called for 7.00 ms",
            "17 ms: codel tick was not called for 7.00 ms",
            "20 ms: codel tick was called 10.0 ms after the time before",
        ]
    );
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_port_is_waited_for_while_an_activity_runs_and_its_activity_is_interrupted() {
    let written = Arc::new(AtomicU64::new(0));
    let turns = Arc::clone(&written);
    let calls = Arc::new(AtomicU64::new(0));
    // It writes in its first three calls, and twice in the second.
    let turn = codel(move || {
        let values = match calls.fetch_add(1, Ordering::SeqCst) {
            0 | 2 => 1,
            1 => 2,
            _ => 0,
        };
        turns.fetch_add(values, Ordering::SeqCst);
        "pause::start"
    });
    let body = component(&[("turn", turn)]);
    body.written.set(written).unwrap();
    let port = body.plan.component().ports.find(|port| port.name == "pose").unwrap();
    let rule = Rule::Beat {
        of: Beats::Port(port),
        least: MS,
        longest: Duration::from_millis(15),
        during: Some(service(&body, "round")),
    };
    let (instance, told, clock) = stepped(&body, vec![rule], true);
    clock.step(Duration::from_millis(100));
    assert_eq!(told.lines(), [""; 0], "nothing runs");
    let round = request(&instance, "round");
    clock.step(Duration::from_millis(15));
    // It began at 110, at the next tick.
    assert_eq!(told.lines(), [""; 0]);
    clock.step(Duration::from_millis(85));
    assert_eq!(next(&round), "accepted 3");
    assert_eq!(told.lines()[0], "120 ms: port pose was written 0.00 us after the time before");
    assert_eq!(next(&round), "done", "it was interrupted, and its codel of state stop ended it");
    assert_eq!(instance.violations(), [1]);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_port_that_is_never_written_again_is_told_at_that_date() {
    let body = component(&[]);
    let port = body.plan.component().ports.find(|port| port.name == "pose").unwrap();
    let (least, longest) = (Duration::ZERO, Duration::from_millis(15));
    let rule = Rule::Beat { of: Beats::Port(port), least, longest, during: None };
    let (instance, told, clock) = stepped(&body, vec![rule], false);
    clock.step(Duration::from_millis(100));
    assert_eq!(told.lines(), ["15 ms: port pose was not written for 15.0 ms"]);
    instance.shutdown(LONG).unwrap();
    assert_eq!(told.all().len(), 1);
}

#[test]
fn what_no_step_of_an_order_allows_is_told_with_what_it_allows() {
    let body = component(&[]);
    let start = |name| vec![Happening::Start(service(&body, name))];
    let order = Order::new(
        vec!["new".into(), "ready".into()],
        vec![("calibrate".into(), start("calibrate")), ("move".into(), calls(&body, "go"))],
        &[(0, 0, 1), (1, 1, 1)],
    );
    let (instance, told, clock) = stepped(&body, vec![Rule::Order(order.unwrap())], false);
    let done = |service| assert_eq!(next(&request(&instance, service)), "done");
    done("move");
    done("calibrate");
    done("move");
    done("move");
    assert_eq!(instance.violations(), [1]);
    done("calibrate");
    clock.step(Duration::ZERO);
    assert_eq!(
        told.lines(),
        [
            "0 ms: codel go was called in state new, where only calibrate may come",
            "0 ms: calibrate started in state ready, where only move may come",
        ]
    );
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_formula_is_judged_at_each_event_with_the_dates_of_those_before() {
    let body = component(&[]);
    // go -> once[0, 30 ms] calibrate
    let within = Bounds { least: 0, most: 30_000_000 };
    let zero = vec![Happening::End(service(&body, "calibrate"))];
    let rule = program(vec![
        (Part::Happens(calls(&body, "go")), "go"),
        (Part::Happens(zero), "end(calibrate)"),
        (Part::Once(within, 1), "once[0, 30 ms] end(calibrate)"),
        (Part::Implies(0, 2), "go -> once[0, 30 ms] end(calibrate)"),
    ]);
    let (instance, told, clock) = stepped(&body, vec![rule], false);
    let done = |service| assert_eq!(next(&request(&instance, service)), "done");
    done("move");
    done("calibrate");
    clock.step(Duration::from_millis(30));
    done("move");
    clock.step(MS);
    done("move");
    clock.step(Duration::ZERO);
    let why = "codel go was called, and `once[0, 30 ms] end(calibrate)` did not hold";
    assert_eq!(told.lines(), [format!("0 ms: {why}"), format!("31 ms: {why}")]);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_formula_about_what_runs_interrupts_the_activity_that_breaks_it() {
    let body = component(&[]);
    // turn -> not previous run(round): the second call in the same run.
    let rule = program(vec![
        (Part::Happens(calls(&body, "turn")), "turn"),
        (Part::Happens(calls(&body, "turn")), "turn"),
        (Part::Previous(1), "previous turn"),
        (Part::Runs(service(&body, "round")), "run(round)"),
        (Part::And(2, 3), "previous turn and run(round)"),
        (Part::Not(4), "not (previous turn and run(round))"),
        (Part::Implies(0, 5), "turn -> not (previous turn and run(round))"),
    ]);
    let (instance, told, clock) = stepped(&body, vec![rule], true);
    let round = request(&instance, "round");
    clock.step(Duration::from_millis(50));
    assert_eq!((next(&round), next(&round)), ("accepted 3".into(), "done".into()));
    let all = told.all();
    assert_eq!((all.len(), all[0].activity, all[0].date), (1, Some(3), 20_000_000));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn an_event_a_request_and_a_stop_are_heard_of_where_they_happen() {
    let body = component(&[]);
    let round = service(&body, "round");
    let of = [
        Happening::Accept(round),
        Happening::Start(round),
        Happening::Stop(round),
        Happening::End(round),
    ];
    // Broken at each.
    let rule = program(vec![(Part::Happens(of.to_vec()), "it"), (Part::Not(0), "not it")]);
    let (instance, told, clock) = stepped(&body, vec![rule], false);
    let asked = request(&instance, "round");
    clock.step(Duration::from_millis(15));
    assert_eq!(next(&asked), "accepted 3");
    instance.abort(3).unwrap();
    clock.step(Duration::from_millis(15));
    assert_eq!(next(&asked), "done");
    let what: Vec<String> = told.all().into_iter().map(|one| one.what).collect();
    let of = |what: &str| format!("round {what}, and `not it` did not hold");
    assert_eq!(what, ["was accepted", "started", "was asked to stop", "ended"].map(of));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_rule_about_one_task_tells_the_same_as_one_that_several_threads_move_on() {
    let body = component(&[]);
    let (tick, turn) = (calls(&body, "tick"), calls(&body, "turn"));
    // What makes a rule one of several threads, and does not happen here.
    let elsewhere = [vec![], vec![Happening::Accept(service(&body, "hang"))]];
    let order = |never: &Vec<Happening>| {
        let ticks = [tick.clone(), never.clone()].concat();
        let events = vec![("tick".into(), ticks), ("turn".into(), turn.clone())];
        let states = vec!["ticked".into(), "turned".into()];
        Rule::Order(Order::new(states, events, &[(0, 1, 1), (1, 0, 0)]).unwrap())
    };
    let formula = |never: &Vec<Happening>| {
        let within = Bounds { least: 5_000_000, most: 15_000_000 };
        let all = [turn.clone(), never.clone()].concat();
        program(vec![
            (Part::Happens(tick.clone()), "tick"),
            (Part::Happens(all), "turn"),
            (Part::Once(within, 1), "once[5 ms, 15 ms] turn"),
            (Part::Implies(0, 2), "tick -> once[5 ms, 15 ms] turn"),
        ])
    };
    let beat = |others: &[&str]| {
        let of = others.iter().flat_map(|name| codels(&body, name)).collect();
        let (least, longest) = (11 * MS, 40 * MS);
        Rule::Beat { of: Beats::Codels(of), least, longest, during: None }
    };
    let [own, shared] = &elsewhere;
    let rules = vec![
        order(own),
        order(shared),
        formula(own),
        formula(shared),
        beat(&["tick"]),
        beat(&["tick", "zero"]),
    ];
    let (instance, told, clock) = stepped(&body, rules, false);
    clock.step(20 * MS);
    let _round = request(&instance, "round");
    clock.step(30 * MS);
    let all = told.all();
    let of = |rule: usize| {
        let own = all.iter().filter(move |one| one.rule == rule);
        own.map(|one| (one.date, one.what.clone())).collect::<Vec<_>>()
    };
    for rule in [0, 2, 4] {
        assert!(of(rule).len() >= 2, "{all:?}");
        assert_eq!(of(rule), of(rule + 1));
    }
    instance.shutdown(LONG).unwrap();
}

#[test]
fn threads_that_meet_at_a_formula_lose_nothing_and_wait_for_nobody() {
    const CALLS: u64 = 20_000;
    let counts = [(); 3].map(|()| Arc::new(AtomicU64::new(0)));
    let counting = |count: &Arc<AtomicU64>| {
        let count = Arc::clone(count);
        codel(move || match count.fetch_add(1, Ordering::SeqCst) + 1 < CALLS {
            true => "start",
            false => "ether",
        })
    };
    let body = Closures::new(
        "component test {
            task a { }; task b { }; task c { };
            activity one() { task a; codel<start> f() yield start, ether; };
            activity two() { task b; codel<start> g() yield start, ether; };
            activity three() { task c; codel<start> h() yield start, ether; };
        };",
        &[("f", counting(&counts[0])), ("g", counting(&counts[1])), ("h", counting(&counts[2]))],
    );
    let all: Vec<Happening> = ["f", "g", "h"].iter().flat_map(|name| calls(&body, name)).collect();
    let rule = program(vec![(Part::Happens(all), "any"), (Part::Not(0), "not any")]);
    let (instance, _told) = threads(&body, vec![rule]);
    let asked = ["one", "two", "three"].map(|service| request(&instance, service));
    for one in &asked {
        assert!(next(one).starts_with("accepted"));
        assert_eq!(next(one), "done");
    }
    until("what was left is taken in", || {
        instance.violations()[0] + instance.unheard() == 3 * CALLS
    });
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_judgement_of_all_operators_is_that_of_their_definitions() {
    let body = component(&[]);
    let (go, zero) = (calls(&body, "go"), calls(&body, "zero"));
    // zero since go, historically not zero, with the letters go = 0, zero = 1.
    let judge = |parts: Vec<(Part, &str)>, letters: &[(usize, u64)]| {
        let Rule::Formula(program) = program(parts) else { panic!("no formula") };
        let mut judge = genom_runtime::Judge::new(&program);
        letters.iter().map(|&(letter, date)| judge.hear(letter, date).is_none()).collect::<Vec<_>>()
    };
    let two = || vec![(Part::Happens(go.clone()), "go"), (Part::Happens(zero.clone()), "zero")];
    let letters = [(1, 0), (0, 10), (1, 20), (1, 30), (0, 40)];
    let mut since = two();
    since.push((Part::Since(Bounds { least: 0, most: 10 }, 1, 0), "zero since[0, 10] go"));
    assert_eq!(judge(since, &letters), [false, true, true, false, true]);
    let mut always = two();
    always.push((Part::Historically(Bounds { least: 10, most: 20 }, 1), "historically"));
    assert_eq!(judge(always, &letters), [true, true, false, false, true]);
    let mut once = two();
    once.push((Part::Once(Bounds { least: 20, most: u64::MAX }, 0), "once[20, inf] go"));
    assert_eq!(judge(once, &letters), [false, false, false, true, true]);
    let mut never = two();
    never.extend([(Part::Once(ANY, 0), "once go"), (Part::Not(2), "not once go")]);
    assert_eq!(judge(never, &letters), [true, false, false, false, false]);
    let mut either = two();
    either.extend([(Part::Previous(0), "previous go"), (Part::Or(2, 0), "previous go or go")]);
    assert_eq!(judge(either, &letters), [false, true, true, false, true]);
}
