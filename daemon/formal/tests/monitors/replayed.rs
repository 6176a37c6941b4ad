//! Runs with dates that break rules on time, of random components: each date is one that ticks and
//! codels allow, and the judge of the runtime says at these dates that a formula is broken at the end.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use genom_description::model::{CodelIx, Component, Ix as _};
use genom_description::{Options, read_text};
use genom_formal::{Duration as Takes, Fires, Limits, Line, System, Times, Trace};
use genom_runtime::{Happening, Judge, Plan, Program, Rule};

use super::random::Random;
use super::runtime::{rules, small, system};

const MS: u64 = 1_000_000;

/// From nothing to some milliseconds for each codel, and perhaps a fraction.
fn times(model: &Component, mut times: Times, random: &mut Random) -> (Times, Vec<Takes>) {
    let mut ns = |below: usize| {
        let some: &u64 = random.one(&[0, 0, 1, 500_000]);
        MS * u64::try_from(random.below(below)).unwrap() + some
    };
    let takes = |_| {
        let least = ns(2);
        Takes { least, most: Some(least + ns(4)) }
    };
    let all: Vec<Takes> = (0..model.codels.len()).map(takes).collect();
    for (at, takes) in all.iter().enumerate() {
        times.set_one(CodelIx::new(at), *takes);
    }
    (times, all)
}

/// The codel that a line says begins.
fn begins(model: &Component, line: &Line) -> Option<CodelIx> {
    let name = line.what.strip_suffix(" begins")?;
    model.codels.find(|codel| codel.name == name)
}

/// The codel that a line says returns.
fn returns<'l>(model: &Component, line: &'l Line) -> Option<(&'l str, CodelIx)> {
    let (name, how) = line.what.split_once(' ')?;
    let is_end = how.starts_with("yields ") || how == "ends with an exception";
    let codel = model.codels.find(|codel| codel.name == name).filter(|_| is_end)?;
    Some((name, codel))
}

/// Each tick is at its date, and each codel takes as long as it may.
fn is_possible(model: &Component, takes: &[Takes], run: &[(u64, &Line)]) -> Result<(), String> {
    let mut ticks: HashMap<&str, u64> = HashMap::new();
    let mut begun: HashMap<(&str, CodelIx), u64> = HashMap::new();
    let ns = |time: Duration| u64::try_from(time.as_nanos()).unwrap();
    let mut before = 0;
    let end = run.last().map_or(0, |(date, _)| *date);
    for (date, line) in run {
        if *date < before {
            return Err(format!("{date} after {before}"));
        }
        before = *date;
        let task = model.tasks.iter().find(|task| task.name == line.who);
        if let Some(task) = task.filter(|_| line.what == "tick") {
            let (period, delay) = (ns(task.period.unwrap()), ns(task.delay));
            let first = if delay > 0 { delay } else { period };
            let next = ticks.entry(&task.name).or_insert(first);
            if date != next {
                return Err(format!("{} ticks at {date}, not at {next}", task.name));
            }
            *next += period;
        }
        if let Some(codel) = begins(model, line) {
            begun.insert((&line.who, codel), *date);
        } else if let Some((name, codel)) = returns(model, line) {
            let took = date - begun.remove(&(&line.who[..], codel)).ok_or("it did not begin")?;
            let Takes { least, most } = takes[codel.index()];
            if took < least || most.is_some_and(|most| took > most) {
                return Err(format!("{name} took {took}"));
            }
        }
    }
    // What lasts at the end is not over its time, and no tick is left out.
    for ((_, codel), date) in begun {
        if takes[codel.index()].most.is_some_and(|most| end - date > most) {
            return Err(format!("{codel:?} lasts too long"));
        }
    }
    match ticks.values().find(|next| **next < end) {
        Some(tick) => Err(format!("the tick at {tick} is not there")),
        None => Ok(()),
    }
}

/// At these dates the formula is broken by a call in the last step, and by nothing before.
fn is_broken_at_its_end(model: &Component, program: &Program, run: &[(u64, &Line)]) -> bool {
    let (mut judge, heard) = (Judge::new(program), program.hears());
    let broken = run.iter().position(|(date, line)| {
        let call = begins(model, line).map(Happening::Call);
        let letter = heard.iter().position(|one| Some(*one) == call);
        letter.is_some_and(|letter| judge.hear(letter, *date).is_some())
    });
    let end = run.last().unwrap().0;
    broken.is_some_and(|at| {
        // What else begins or waits in the same step comes after it.
        let same = |(date, line): &(u64, &Line)| {
            *date == end && (begins(model, line).is_some() || line.what.contains(" waits for "))
        };
        run[at..].iter().all(same)
    })
}

#[test]
fn dates_of_runs_are_possible_and_break_their_rules() {
    let limits = Limits { states: 3_000, time: Duration::MAX, ..Limits::default() };
    let (mut formulas, mut others) = (0, 0);
    for seed in 0..150 {
        let mut random = Random(seed);
        let delay = random.one(&["", "", " delay 3 ms;"]);
        let text = small(&mut random).replace("period 10 ms;", &format!("period 10 ms;{delay}"));
        let analysis = read_text("demo.gen", &text, &Options::default());
        let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
        let model = plan.component();
        let (system, zero): (System, Times) = system(&plan, 1);
        let (times, takes) = times(model, zero, &mut random);
        for rule in rules(&plan, &mut random) {
            let found = system.fires(&rule, Ok(&times), &limits);
            let (Fires::Can { run, .. } | Fires::Always { run, .. }) = found else { continue };
            let Trace::Dated(run) = run else { continue };
            let run: Vec<(u64, &Line)> = run.iter().map(|one| (one.date, &one.line)).collect();
            let possible = is_possible(model, &takes, &run);
            assert_eq!(possible, Ok(()), "seed {seed}: {rule:?}\n{takes:?}\n{text}\n{run:#?}");
            if let Rule::Formula(program) = &rule {
                let broken = is_broken_at_its_end(model, program, &run);
                assert!(broken, "seed {seed}: {rule:?}\n{takes:?}\n{text}\n{run:#?}");
                formulas += 1;
            } else {
                others += 1;
            }
        }
    }
    assert!(formulas >= 100 && others >= 100, "{formulas} formulas, {others} others");
}
