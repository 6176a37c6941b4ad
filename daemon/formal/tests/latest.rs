//! Tasks that are in time since others are at each codel by some date at the latest, although all that
//! may be waited for together takes longer.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "conformance/random.rs"]
mod random;
mod support;

use std::fmt::Write as _;

use genom_description::model::{Codel, CodelIx, Ix as _};
use genom_formal::{Bounds, Cause, Duration, Limits, Processors, System, Times};
use random::Random;
use support::limits;

const SEEDS: u64 = 400;

/// Control loops with activities of a few states, as of real size, but fewer.
fn component(random: &mut Random) -> String {
    let mut text = String::from("component c { ids { long m0, m1, m2; }; exception E;\n");
    let parameters = |random: &mut Random| {
        let (access, member) = (*random.one(&["in", "out", "inout"]), random.below(3));
        if random.percent(50) { format!("{access} m{member}") } else { String::new() }
    };
    let wcet = |random: &mut Random| 500 * (1 + random.below(4));
    let periods = [*random.one(&["period 5 ms;", "period 10 ms;"]), "period 10 ms;"];
    for (task, period) in periods.into_iter().enumerate() {
        let delay = if random.percent(20) { "delay 2 ms;" } else { "" };
        let period = if task == 1 && random.percent(15) { "" } else { period };
        let delay = if period.is_empty() { "" } else { delay };
        writeln!(
            text,
            " task t{task} {{ {period} {delay} codel<start> t{task}_start({}) yield pause::start
               wcet {} us; }};",
            parameters(random),
            wcet(random),
        )
        .unwrap();
    }
    if random.percent(30) {
        let (parameters, wcet) = (parameters(random), wcet(random));
        writeln!(text, " function f() {{ codel f_run({parameters}) wcet {wcet} us; }};").unwrap();
    }
    let activities = 2 + random.below(2);
    for at in 0..activities {
        let others = (0..activities).filter(|other| *other == at || random.percent(40));
        let others: Vec<String> = others.map(|other| format!("a{other}")).collect();
        write!(text, " activity a{at}() {{ task t{}; interrupts {};", at % 2, others.join(", "))
            .unwrap();
        let second = *random.one(&["main, ether", "pause::main", "main"]);
        for (state, yields) in [("start", second), ("main", "pause::main, stop"), ("stop", "ether")]
        {
            write!(
                text,
                " codel<{state}> a{at}_{state}({}) yield {yields} wcet {} us;",
                parameters(random),
                wcet(random),
            )
            .unwrap();
        }
        text.push_str(if random.percent(50) { " throw E; };\n" } else { " };\n" });
    }
    text + "};"
}

/// Times with which the sums of this task are a little more than its period.
fn too_long(system: &System, random: &mut Random, task: &str) -> Option<Times> {
    let component = system.plan().component();
    let wcet = |codel: &Codel| u64::try_from(codel.wcet?.as_nanos()).ok();
    let mut most: Vec<Option<u64>> = component.codels.iter().map(wcet).collect();
    let mut times = system.declared_times();
    let part = 100 + random.below(20);
    // What another task takes meanwhile changes as well.
    for _ in 0..3 {
        let sums = system.schedule(&times, Processors::Own, 0);
        let sum = sums.tasks.iter().find(|one| one.name == task)?;
        let work = match sum.response {
            Ok(most) | Err(Cause::Late(most)) if most > 0 => u128::from(most),
            _ => return None,
        };
        let scaled = |ns: u64| {
            let ns = u128::from(ns) * u128::from(sum.period) * part as u128 / 100 / work;
            u64::try_from(ns).unwrap()
        };
        for (most, at) in most.iter_mut().zip(0..) {
            *most = most.map(scaled);
            times.set_one(CodelIx::new(at), Duration { least: 0, most: *most });
        }
    }
    Some(times)
}

#[test]
fn tasks_that_the_latest_dates_show_to_be_in_time_are_in_time() {
    let (mut compared, mut exact) = (0, 0);
    for seed in 0..SEEDS {
        let mut random = Random(seed);
        let text = component(&mut random);
        let bounds =
            Bounds { instances: 1, kill: false, abort: random.percent(50), ..Bounds::default() };
        let system = support::system(&text, bounds, true);
        let Some(times) = too_long(&system, &mut random, "t0") else { continue };
        let sums = system.schedule(&times, Processors::Own, 0);
        // With next to no zones.
        let found = system.check_ticks(&times, &Limits { states: 20, ..limits() });
        let is_found = |name: &str| {
            let one = found.tasks.iter().find(|one| one.name == name)?;
            (!one.is_late() && !one.is_open()).then_some(one.response)
        };
        let late = sums.tasks.iter().filter(|one| one.response.is_err());
        let by_dates: Vec<_> =
            late.filter_map(|one| Some((one.name.clone(), is_found(&one.name)?))).collect();
        if by_dates.is_empty() {
            continue;
        }
        let zones = system.check_times(&times, &Limits { states: 40_000, ..limits() });
        for (name, response) in by_dates {
            let exactly = zones.tasks.iter().find(|one| one.name == name).unwrap();
            // Zones that were seen count even if there are more.
            assert!(!exactly.is_late(), "seed {seed}, {name}\n{text}\n{times:?}");
            assert!(response >= exactly.response, "seed {seed}, {name}\n{text}\n{times:?}");
            compared += usize::from(zones.limit().is_none());
            exact += usize::from(response == exactly.response);
        }
    }
    assert!(compared > 20 && exact > 5, "{compared} {exact}");
}

/// Two activities of `t0`, and one of `t1` for which the second one waits: together they are late, and
/// any two of them are not.
fn three(interrupts: [&str; 3]) -> String {
    let activity = |name: &str, task: &str, codel: &str, others: &str| {
        format!(
            " activity {name}() {{ task {task}; interrupts {name}{others};
               codel<start> {name}_start{codel}; }};"
        )
    };
    format!(
        "component c {{ ids {{ long m; }};
           task t0 {{ period 10 ms; codel<start> p() yield pause::start wcet 1 ms; }};
           task t1 {{ period 20 ms; codel<start> q() yield pause::start wcet 3 ms; }};
         {}{}{} }};",
        activity("x", "t0", "() yield pause::start wcet 2 ms", interrupts[0]),
        activity("y", "t0", "(inout m) yield pause::start wcet 3500 us", interrupts[1]),
        activity("z", "t1", "(inout m) yield pause::start wcet 4 ms", interrupts[2]),
    )
}

#[test]
fn activities_of_which_one_interrupts_another_may_both_have_begun() {
    let not_late = |interrupts: [&str; 3], limits: &Limits| {
        let bounds = Bounds { instances: 1, kill: false, abort: false, ..Bounds::default() };
        let system = support::system(&three(interrupts), bounds, true);
        let found = system.check_ticks(&system.declared_times(), limits);
        let task = found.tasks.iter().find(|one| one.name == "t0").unwrap();
        !task.is_late() && !task.is_open()
    };
    let few = Limits { states: 20, ..limits() };
    // Who interrupts was sent before: `x`, then `z`, then `y`.
    for interrupts in [["", "", ""], ["", "", ", y"], [", z", "", ""], [", z", "", ", y"]] {
        assert!(!not_late(interrupts, &limits()), "{interrupts:?}");
        assert!(!not_late(interrupts, &few), "{interrupts:?}");
    }
    // Each of the two interrupts the other one, or there is no order of the three.
    for interrupts in [["", ", z", ", y"], ["", ", x, z", ", x"], [", y", ", z", ", x"]] {
        assert_eq!(not_late(interrupts, &few), not_late(interrupts, &limits()), "{interrupts:?}");
    }
}

#[test]
fn a_codel_does_not_wait_for_what_an_activity_behind_it_keeps_away() {
    // With `keeps` behind it, `first` does not wait for `rival`, whose task is late: each of the two
    // interrupts the other one.
    let text = |others: &str| {
        format!(
            "component c {{ ids {{ long m; }};
               task fast {{ period 10 ms; codel<start> q() yield pause::main wcet 1 ms;
                                        codel<main> f() yield pause::main wcet 4 ms; }};
               task slow {{ period 10 ms; codel<start> s() yield pause::start wcet 1 ms; }};
               activity first() {{ task slow; interrupts first;
                 codel<start> first_start(inout m) yield pause::start wcet 3 ms; }};
               activity keeps() {{ task slow; interrupts keeps{others};
                 codel<start> keeps_start() yield ether wcet 4 ms; }};
               activity rival() {{ task fast; interrupts rival, keeps;
                 codel<start> rival_start(inout m) yield ether wcet 3 ms; }}; }};"
        )
    };
    for (others, is_late) in [(", rival", false), ("", true)] {
        let bounds = Bounds { instances: 1, kill: false, abort: false, ..Bounds::default() };
        let system = support::system(&text(others), bounds, true);
        let times = system.declared_times();
        let slow = |limits: &Limits| {
            let found = system.check_ticks(&times, limits);
            let task = found.tasks.into_iter().find(|one| one.name == "slow").unwrap();
            (task.is_late(), task.is_open(), task.bound)
        };
        // With all zones, and with next to none.
        assert_eq!(slow(&limits()), (is_late, false, false), "{others}");
        let few = slow(&Limits { states: 20, ..limits() });
        assert_eq!(few, (is_late, false, !is_late), "{others}");
    }
}
