//! What is found of small components, and how large their state spaces are.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use genom_formal::{Bounds, Limits, Property, System, Verdict};
use support::limits;

#[path = "sizes/component.rs"]
mod component;
#[path = "conformance/components.rs"]
mod components;
#[path = "conformance/random.rs"]
mod random;

fn system(text: &str, bounds: Bounds) -> System {
    support::system(text, bounds, true)
}

/// What violates each property, in words.
fn found(text: &str, properties: &[Property]) -> Vec<String> {
    let report = system(text, Bounds::default()).check(properties, &limits());
    let of = |(property, verdict): &(Property, Verdict)| match verdict {
        Verdict::Holds => Vec::new(),
        Verdict::Violated(found) => {
            found.iter().map(|found| format!("{}: {}", property.name(), found.what)).collect()
        }
        Verdict::Undecided(why) => vec![format!("{}: not decided: {why}", property.name())],
    };
    report.verdicts.iter().flat_map(of).collect()
}

const SOUND: &str = "component c {
  ids { long x; };
  task t { period 10 ms; codel<start> t0(out x) yield ether; };
  attribute set(in x);
  activity go() { task t; codel<start> g0(in x) yield pause::start, ether;
    codel<stop> g1() yield ether; interrupts go; };
};";

#[test]
fn all_properties_hold_of_a_sound_component() {
    assert_eq!(found(SOUND, &Property::ALL), Vec::<String>::new());
}

#[test]
fn a_stop_codel_that_pauses_in_a_task_without_period_blocks_the_shutdown() {
    let text = "component c {
      task t { };
      activity go() { task t; codel<start> g0() yield pause::start, ether;
        codel<stop> g1() yield pause::stop, ether; };
    };";
    let system = system(text, Bounds::default());
    let report = system.check(&[Property::Stuck], &limits());
    let [(_, Verdict::Violated(found))] = &report.verdicts[..] else { panic!("{report:?}") };
    let run: Vec<String> =
        found[0].run.iter().map(|line| format!("{}: {}", line.who, line.what)).collect();
    assert_eq!(
        run,
        [
            "t: starts",
            "client: requests go",
            "go: is accepted",
            "t: go: g0 yields pause::start",
            "client: asks the component to end",
            "t: go: g1 yields pause::stop",
        ]
    );
}

#[test]
fn a_circle_without_pause_is_a_loop_in_a_periodic_task_only() {
    let circle = |period: &str| {
        format!(
            "component c {{ task t {{ {period} }};
             activity go() {{ task t; codel<start> g0() yield main;
               codel<main> g1() yield start, ether; }}; }};"
        )
    };
    assert_eq!(
        found(&circle("period 5 ms;"), &[Property::Loop]),
        ["loop: activity go may go from state to state without pause for ever: start, main"]
    );
    assert_eq!(found(&circle(""), &[Property::Loop]), Vec::<String>::new());
}

#[test]
fn an_activity_that_was_asked_to_stop_must_not_sleep() {
    let stops = |yields: &str| {
        format!(
            "component c {{ event alarm; task t {{ period 5 ms; }};
             activity go() {{ task t; codel<start> g0() yield pause::start, ether;
               codel<alarm> g1() yield ether; codel<stop> g2() yield {yields}; }}; }};"
        )
    };
    assert_eq!(found(&stops("pause::stop, ether"), &[Property::Stop]), Vec::<String>::new());
    assert_eq!(
        found(&stops("pause::stop, sleep, ether"), &[Property::Stop]),
        ["stop: activity go may sleep in state stop once it was asked to stop: only an event \
             ends that"]
    );
}

#[test]
fn what_only_an_event_leads_to_is_reached_if_events_are_fired() {
    let text = "component c { event alarm;
      task t { period 5 ms; };
      activity go() { task t; codel<start> g0() yield pause::start;
        codel<alarm> g1() yield ether; }; };";
    assert_eq!(found(text, &[Property::Reach]), Vec::<String>::new());
    let bounds = Bounds { fire: false, ..Bounds::default() };
    let report = system(text, bounds).check(&[Property::Reach], &limits());
    let [(_, Verdict::Violated(found))] = &report.verdicts[..] else { panic!("{report:?}") };
    assert_eq!(found[0].what, "codel g1 never runs");
}

#[test]
fn services_that_wait_for_each_other_can_never_run() {
    let text = "component c { ids { long x; };
      attribute a(in x) { after b; };
      attribute b(in x) { after a; };
      attribute d(in x) { before e; };
      attribute e(in x) { after d; }; };";
    let order = |of: &str, all: &str| {
        format!(
            "order: {of} can never run: there is no order of {all} in which `before` and `after` hold"
        )
    };
    assert_eq!(found(text, &[Property::Order]), [order("a", "a, b"), order("b", "b, a")]);
    // The exploration finds the same without looking at the rule.
    assert_eq!(
        found(text, &[Property::Reach]),
        ["reach: no request of a is ever accepted", "reach: no request of b is ever accepted"]
    );
}

#[test]
fn what_passes_the_limits_is_not_decided() {
    let limits = Limits { states: 3, ..limits() };
    // No activity gets a slot, which nothing but the states says.
    let bounds = Bounds { slots: 0, ..Bounds::default() };
    let report = system(SOUND, bounds).check(&Property::ALL, &limits);
    for (property, verdict) in report.verdicts {
        // All others follow from the rules, from the description and from random runs.
        let open = property == Property::Reach;
        assert_eq!(verdict == Verdict::Holds, !open, "{property:?}: {verdict:?}");
        assert_eq!(matches!(verdict, Verdict::Undecided(_)), open, "{property:?}");
    }
}

#[test]
fn what_is_large_is_decided_by_its_parts() {
    // Four activities, three at a time: more states than the first look sees.
    let activity = |at: usize| {
        format!(
            "activity a{at}() {{ task t; codel<start> s{at}() yield main, pause::main;
               codel<main> m{at}() yield pause::main, stop; codel<stop> e{at}() yield ether; }};"
        )
    };
    let activities: String = (0..4).map(activity).collect();
    let text =
        |more: &str| format!("component c {{ task t {{ period 10 ms; }}; {activities} {more} }};");
    let bounds = Bounds { instances: 3, ..Bounds::default() };
    let limits = Limits { states: 2_000, ..limits() };
    let verdicts = |text: &str| system(text, bounds).check(&Property::ALL, &limits).verdicts;
    for (property, verdict) in verdicts(&text("")) {
        assert_eq!(verdict, Verdict::Holds, "{property:?}");
    }
    // What never runs is not seen in any part, and cannot be by the description.
    let never = "attribute x() { after y; }; attribute y() { after x; };";
    let found = verdicts(&text(never)).into_iter().find(|(one, _)| *one == Property::Reach);
    let Some((_, Verdict::Violated(found))) = found else { panic!("{found:?}") };
    let what: Vec<&str> = found.iter().map(|found| found.what.as_str()).collect();
    assert_eq!(what, ["no request of x is ever accepted", "no request of y is ever accepted"]);
}

#[test]
fn a_pause_without_ticks_is_answered_only_if_something_else_happens() {
    let text = |period: &str| {
        format!(
            "component c {{ task t {{ {period} }};
             activity go() {{ task t; codel<start> g0() yield pause::start, ether; }}; }};"
        )
    };
    assert_eq!(found(&text("period 5 ms;"), &[Property::Answer]), Vec::<String>::new());
    assert_eq!(
        found(&text(""), &[Property::Answer]),
        ["answer: a request of go may never be answered: it pauses in start, and its task has no \
          period: that takes something else to happen"]
    );
}

#[test]
fn what_may_never_be_answered_is_found_in_a_component_with_three_tasks_and_seven_activities() {
    // Its tasks alone have more than 50,000 states.
    let size = component::Size { tasks: 3, activities: 7, functions: 3 };
    let text = component::component(&mut random::Random(0), size);
    let found = found(&text, &[Property::Start, Property::Answer]);
    let [told] = &found[..] else { panic!("{found:?}") };
    assert!(
        told.contains("may never be answered: it pauses in main, and its task has no"),
        "{told}"
    );
}

#[test]
fn an_event_keeps_nobody_from_an_answer_unless_what_it_begins_sleeps_or_has_no_end() {
    let verdict = |event: &str, stop: &str, states: usize| {
        let text = format!(
            "component c {{ event alarm; task t {{ period 5 ms; }};
             activity go() {{ task t; codel<start> g0() yield pause::start;
               codel<alarm> g1() yield {event}; codel<stop> g2() yield {stop}; }}; }};"
        );
        let system = system(&text, Bounds::default());
        let limits = Limits { states, ..limits() };
        system.check(&[Property::Answer], &limits).verdicts.remove(0).1
    };
    let all = limits().states;
    // By all states, and by nothing but the rules.
    for (states, stop) in [(all, "ether"), (2, "ether"), (all, "pause::stop, ether")] {
        assert_eq!(verdict("ether", stop, states), Verdict::Holds, "{states} {stop}");
        assert_eq!(verdict("pause::alarm, ether", stop, states), Verdict::Holds, "{states} {stop}");
    }
    // An event is taken at the beginning of a pass (R3). An activity that ends in the pass in which
    // it begins to stop takes none; one that stops for longer may sleep in what the event begins.
    assert_eq!(verdict("sleep, ether", "ether", all), Verdict::Holds);
    assert!(matches!(verdict("sleep, ether", "pause::stop, ether", all), Verdict::Violated(_)));
    for stop in ["ether", "pause::stop, ether"] {
        assert!(matches!(verdict("sleep, ether", stop, 2), Verdict::Undecided(_)), "{stop}");
    }
}

#[test]
fn what_never_ends_once_it_is_asked_keeps_others_waiting() {
    let text = |stop: &str| {
        format!(
            "component c {{ event alarm; task t {{ period 5 ms; }};
             activity go() {{ task t; codel<start> g0() yield pause::start;
               codel<alarm> g1() yield ether; codel<stop> g2() yield {stop}; }};
             activity back() {{ task t; codel<start> b0() yield ether; interrupts go; }}; }};"
        )
    };
    // It goes on until it is asked to stop, which is fine.
    assert_eq!(found(&text("pause::stop, ether"), &[Property::Answer]), Vec::<String>::new());
    let all = found(&text("sleep, ether"), &[Property::Answer]);
    let go = "answer: a request of go may never be answered: nothing that happens by itself leads from \
              sleep to its end";
    assert!(all.iter().any(|one| one == go), "{all:?}");
}

#[test]
fn the_rules_answer_for_nothing_that_may_sleep_once_it_was_asked_to_stop() {
    let text = |stop: &str| {
        format!(
            "component c {{ event alarm; task t {{ period 5 ms; }};
             activity go() {{ task t; codel<start> g0() yield pause::start, ether;
               codel<stop> g1() yield {stop}, ether; }}; }};"
        )
    };
    let verdict = |text: &str, states: usize| {
        let limits = Limits { states, ..limits() };
        let system = system(text, Bounds { fire: false, ..Bounds::default() });
        system.check(&[Property::Answer], &limits).verdicts.remove(0).1
    };
    // Where two states are seen, the rules decide.
    assert_eq!(verdict(&text("pause::stop"), 2), Verdict::Holds);
    let sleeps = text("sleep");
    assert!(matches!(verdict(&sleeps, 8_000), Verdict::Violated(_)));
    assert_ne!(verdict(&sleeps, 2), Verdict::Holds);
}

#[test]
fn rules_and_states_say_the_same_of_answers() {
    let (mut both, mut violated) = (0, 0);
    for seed in 0..150 {
        let mut random = random::Random(seed);
        let text = components::component(&mut random);
        let (instances, fire) = (1 + random.below(2), random.percent(50));
        let system = system(&text, Bounds { instances, fire, ..Bounds::default() });
        let verdict = |states: usize| {
            let limits = Limits { states, ..limits() };
            system.check(&[Property::Answer], &limits).verdicts.remove(0).1
        };
        let by_states = verdict(8_000);
        if matches!(by_states, Verdict::Undecided(_)) {
            continue;
        }
        violated += usize::from(by_states != Verdict::Holds);
        // Nothing but the rules, and parts of few states.
        match (&by_states, verdict(2)) {
            (_, Verdict::Undecided(_)) => {}
            (Verdict::Holds, Verdict::Holds) | (Verdict::Violated(_), Verdict::Violated(_)) => {
                both += 1;
            }
            (states, rules) => panic!("seed {seed}: {states:?}, {rules:?}\n{text}"),
        }
    }
    assert!(both > 10 && violated > 3, "{both} {violated}");
}
