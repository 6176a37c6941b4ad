//! What is found of the time that components take.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use genom_formal::{Bounds, Duration, Limits, Longest, System, TimedReport};
use support::{DUO, limits, running};

#[path = "conformance/components.rs"]
mod components;
#[path = "conformance/random.rs"]
mod random;

const MS: u64 = 1_000_000;

/// The two tasks, if each codel takes at least a millisecond and `sb` at most so many.
fn duo(most: u64) -> TimedReport {
    let system = running(DUO);
    let component = system.plan().component();
    let mut times = system.declared_times();
    for (codel, most) in [("fa", 3), ("sb", most), ("sw", 20)] {
        let duration = Duration { least: MS, most: Some(most * MS) };
        assert!(times.set(component, codel, duration));
    }
    system.check_times(&times, &limits())
}

#[test]
fn a_cycle_that_ends_at_its_next_tick_is_an_overrun() {
    // States and zones: a change of these is a change of the rules, or of the exploration
    // (`docs/verify.md` compares them). TChecker stores as many zones for 6 ms, and for 8 ms one more:
    // that of the location `late_fast`, which only the exported model has.
    for (most, overruns, size) in [(6, false, (28, 51)), (7, true, (39, 70)), (8, true, (39, 76))] {
        let report = duo(most);
        assert_eq!(report.limit(), None);
        let [fast, slow] = &report.tasks[..] else { panic!("{report:?}") };
        assert_eq!(!fast.overrun.is_empty(), overruns, "sb takes up to {most} ms");
        assert!(slow.overrun.is_empty());
        if !overruns {
            // It waits for `sb`, then runs.
            assert_eq!(fast.response, Some(9 * MS));
        }
        // It waits for `fast` in turn, and then makes two steps.
        assert_eq!(slow.response, Some((3 + most + 20) * MS));
        assert_eq!((report.explored.states(), report.explored.zones()), size);
    }
}

#[test]
fn an_overrun_is_shown_with_dates_and_who_waits_for_whom() {
    let report = duo(8);
    let lines = report.tasks[0].overrun.iter().map(|dated| {
        let ms = dated.date / MS;
        assert_eq!(dated.date % MS, 0);
        format!("{ms} ms {}: {}", dated.line.who, dated.line.what)
    });
    let lines: Vec<String> = lines.collect();
    let last = &lines[lines.len().saturating_sub(7)..];
    assert_eq!(
        last,
        [
            "40 ms slow: tick",
            "40 ms slow: sb begins",
            "40 ms fast: fa waits for sb",
            "47 ms slow: sb yields work",
            "47 ms fast: fa begins",
            "47 ms slow: sw begins",
            "50 ms fast: tick",
        ]
    );
    // What the cycle that is late is made of: its whole period.
    let parts = report.tasks[0].spent.iter();
    let parts: Vec<_> = parts.map(|one| (one.codel.as_str(), &one.awaited[..], one.ns)).collect();
    assert_eq!(parts, [("fa", &["sb".to_owned()][..], 7 * MS), ("fa", &[], 3 * MS)]);
    // Either would do: `sb` shorter than what `fa` leaves, or the other way round.
    let needed = [("fa".to_owned(), 2 * MS), ("sb".to_owned(), 7 * MS)];
    let mut found = report.tasks[0].needed.clone();
    found.sort();
    assert_eq!(found, needed);
}

#[test]
fn a_component_too_large_for_its_zones_is_decided_by_sums_or_by_a_run() {
    let activity = |at: usize| {
        format!(
            "activity a{at}() {{ task t; codel<start> s{at}() yield main wcet 1 ms;
               codel<main> m{at}() yield pause::main wcet 1 ms; interrupts a{at}; }};"
        )
    };
    let activities: String = (0..4).map(activity).collect();
    let report = |period: u64| {
        let text = format!("component duo {{ task t {{ period {period} ms; }}; {activities} }};");
        let system = running(&text);
        let (times, limits) = (system.declared_times(), Limits { states: 3000, ..limits() });
        assert!(system.check_times(&times, &limits).limit().is_some());
        system.check_ticks(&times, &limits)
    };
    // Two codels of each in one cycle: eight milliseconds.
    let fits = report(9);
    assert!(!fits.tasks[0].is_open() && !fits.tasks[0].is_late());
    assert_eq!(fits.tasks[0].response, Some(8 * MS));
    let late = report(8);
    assert!(late.tasks[0].is_late());
    let last = &late.tasks[0].overrun.last().unwrap().line;
    assert_eq!((last.who.as_str(), last.what.as_str()), ("t", "tick"));
}

#[test]
fn clients_wait_for_a_tick_and_for_what_they_interrupt() {
    let response = |stop: &str| {
        let text = format!(
            "component c {{ task t {{ period 10 ms; }};
             activity go() {{ task t; codel<start> g0() yield pause::main wcet 1 ms;
               codel<main> g1() yield pause::main, ether wcet 1 ms;
               codel<stop> g2() yield {stop} wcet 2 ms; interrupts go; }}; }};"
        );
        let system = running(&text);
        let found = system.respond(&system.declared_times(), &limits());
        let [go] = &found[..] else { panic!("{found:?}") };
        assert_eq!(go.service, "go");
        (go.begins.clone(), go.ends.clone())
    };
    // Asked just after a pass began, it stops at the next tick, in 2 ms; the next one begins at the
    // tick after that.
    let most = |ms: u64| Longest::Most(ms * MS);
    assert_eq!(response("ether"), (most(20), most(12)));
    // One pause: a period more of each.
    let (begins, ends) = response("pause::stop, ether");
    assert!(matches!(begins, Longest::More(_)), "{begins:?}");
    assert!(matches!(ends, Longest::Unbounded(_)), "{ends:?}");
}

/// A random component with times of a quarter of a millisecond each, and few requests.
fn random(seed: u64) -> (System, genom_formal::Times, String) {
    let mut random = random::Random(seed);
    let text = components::component(&mut random);
    let bounds = Bounds {
        instances: 1,
        fire: random.percent(30),
        kill: false,
        abort: random.percent(50),
        ..Bounds::default()
    };
    let system = support::system(&text, bounds, true);
    let mut times = system.declared_times();
    let names: Vec<String> =
        system.plan().component().codels.iter().map(|codel| codel.name.clone()).collect();
    for name in names {
        let most = u64::try_from(random.below(5)).unwrap() * MS / 4;
        let least = if random.percent(30) { most / 2 } else { 0 };
        let duration = Duration { least, most: Some(most) };
        times.set(system.plan().component(), &name, duration);
    }
    (system, times, text)
}

#[test]
fn tasks_apart_are_what_they_are_together_and_searches_tell_the_truth() {
    let (mut compared, mut late, mut found, mut fewer) = (0, 0, 0, 0);
    for seed in 0..300 {
        let (system, times, text) = random(seed);
        let whole = system.check_times(&times, &Limits { states: 6_000, ..limits() });
        if whole.limit().is_some() {
            continue;
        }
        let apart = system.check_ticks(&times, &limits());
        fewer += usize::from(apart.explored.zones() < whole.explored.zones());
        // With next to no zones, sums and the search for a late run are left.
        let rest = system.check_ticks(&times, &Limits { states: 20, ..limits() });
        for (at, task) in whole.tasks.iter().enumerate() {
            let name = &task.name;
            compared += 1;
            late += usize::from(task.is_late());
            assert_eq!(apart.tasks[at].is_late(), task.is_late(), "seed {seed}, {name}\n{text}");
            assert_eq!(apart.tasks[at].response, task.response, "seed {seed}, {name}\n{text}");
            let rest = &rest.tasks[at];
            if !rest.is_open() {
                assert_eq!(rest.is_late(), task.is_late(), "seed {seed}, {name}\n{text}");
                assert!(rest.is_late() || rest.response >= task.response, "seed {seed}, {name}");
                found += 1;
            }
        }
    }
    let counts = format!("{compared} compared, {late} late, {found} without zones, {fewer} fewer");
    assert!(compared > 60 && late > 5 && found > 30 && fewer > 5, "{counts}");
}
