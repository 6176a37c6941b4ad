//! What is found of the time that components take.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{Bounds, Duration, Limits, System, TimedReport};
use genom_runtime::Plan;

const MS: u64 = 1_000_000;

/// Two tasks and one exclusion: `fast` waits for `slow` at times.
const DUO: &str = "component duo { ids { long shared; };
  task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; codel<start> sb(inout shared) yield work wcet 8 ms;
    codel<work> sw() yield pause::start wcet 20 ms; }; };";

fn system(text: &str) -> System {
    let analysis =
        read_text("duo.gen", text, &Options { standard_interface: false, ..Options::default() });
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    System::new(&plan, Bounds { kill: false, ..Bounds::default() })
}

/// However slow the machine is.
fn limits() -> Limits {
    Limits { time: std::time::Duration::MAX, ..Limits::default() }
}

/// The two tasks, if each codel takes at least a millisecond and `sb` at most so many.
fn duo(most: u64) -> TimedReport {
    let system = system(DUO);
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
    // States and zones: a change of these is a change of the rules, or of the exploration.
    for (most, overruns, size) in [(6, false, (28, 55)), (7, true, (39, 73)), (8, true, (39, 87))] {
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
        let system = system(&text);
        let limits = Limits { states: 500, ..limits() };
        system.check_ticks(&system.declared_times(), &limits)
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
