//! Random formulas on random events, against the definitions of their operators: of every part, at
//! every event, from all events so far.

#![allow(clippy::unwrap_used)]

use genom_description::model::{CodelIx, Ix as _, ServiceIx};
use genom_monitor::{Bounds, Happening, Judge, Part, Program};
use proptest::collection::vec;
use proptest::prelude::*;

/// Of eight things that may happen, this one.
fn happening(letter: usize) -> Happening {
    let (codel, service) = (CodelIx::new, ServiceIx::new);
    match letter % 8 {
        0 => Happening::Call(codel(0)),
        1 => Happening::Return(codel(0)),
        2 => Happening::Call(codel(1)),
        3 => Happening::Start(service(0)),
        4 => Happening::End(service(0)),
        5 => Happening::Start(service(1)),
        6 => Happening::End(service(1)),
        _ => Happening::Accept(service(0)),
    }
}

/// What a part is made from: its kind, two of the parts before it, and bounds.
type Seed = ((u8, usize, usize), (u64, u64));

/// A part that refers to some of those before it.
fn part(before: &[Part], ((kind, a, b), (least, width)): Seed) -> Part {
    let at = before.len();
    let heard = |letter: usize| match letter % 3 {
        0 => Part::Happens(vec![happening(letter / 3), happening(a)]),
        _ => Part::Happens(vec![happening(letter / 3)]),
    };
    // The first ones hear of the two events of a call.
    if at < 2 {
        return Part::Happens(vec![happening(at)]);
    }
    let bounds = match width {
        0..3 => Bounds { least: 0, most: u64::MAX },
        3..6 => Bounds { least, most: u64::MAX },
        _ => Bounds { least, most: least + width - 5 },
    };
    let (first, second) = (a % at, b % at);
    match kind {
        0 => heard(b),
        1 => Part::Runs(ServiceIx::new(b % 2)),
        2 => Part::Constant(b.is_multiple_of(2)),
        3 => Part::Not(first),
        4 | 5 => Part::And(first, second),
        6 => Part::Or(first, second),
        7 | 8 => Part::Implies(first, second),
        9 | 10 => Part::Previous(first),
        11 => Part::Once(bounds, first),
        12 => Part::Historically(bounds, first),
        13 | 14 => Part::Since(bounds, first, second),
        // What stands in a formula twice.
        _ => before[first].clone(),
    }
}

fn formula(seeds: &[Seed]) -> Vec<Part> {
    let mut parts = Vec::new();
    for seed in seeds {
        parts.push(part(&parts, *seed));
    }
    parts
}

/// The values of all parts at each of these events, by their definitions.
fn values(parts: &[Part], events: &[(Happening, u64)]) -> Vec<Vec<bool>> {
    let mut all: Vec<Vec<bool>> = Vec::new();
    for (now, (what, date)) in events.iter().enumerate() {
        let mut held: Vec<bool> = Vec::new();
        for part in parts {
            let was = |a: usize, then: usize| if then == now { held[a] } else { all[then][a] };
            let within = |bounds: &Bounds| {
                let bounds = *bounds;
                (0..=now).filter(move |then| {
                    (bounds.least..=bounds.most).contains(&(date - events[*then].1))
                })
            };
            let runs = |service: ServiceIx| {
                let run = |count: u32, (what, _): &(Happening, u64)| match *what {
                    Happening::Start(other) if other == service => count + 1,
                    Happening::End(other) if other == service => count.saturating_sub(1),
                    _ => count,
                };
                events[..=now].iter().fold(0, run) > 0
            };
            held.push(match part {
                Part::Constant(value) => *value,
                Part::Happens(heard) => heard.contains(what),
                Part::Runs(service) => runs(*service),
                Part::Not(a) => !held[*a],
                Part::And(a, b) => held[*a] && held[*b],
                Part::Or(a, b) => held[*a] || held[*b],
                Part::Implies(a, b) => !held[*a] || held[*b],
                Part::Previous(a) => now > 0 && all[now - 1][*a],
                Part::Once(bounds, a) => within(bounds).any(|then| was(*a, then)),
                Part::Historically(bounds, a) => within(bounds).all(|then| was(*a, then)),
                Part::Since(bounds, a, b) => within(bounds)
                    .any(|then| was(*b, then) && (then + 1..=now).all(|after| was(*a, after))),
            });
        }
        all.push(held);
    }
    all
}

/// The part that is to blame if the last one does not hold.
fn blamed(parts: &[Part], held: &[bool]) -> Option<usize> {
    let mut at = parts.len() - 1;
    if held[at] {
        return None;
    }
    loop {
        at = match parts[at] {
            Part::Implies(_, b) => b,
            Part::And(a, b) => {
                if held[a] {
                    b
                } else {
                    a
                }
            }
            _ => return Some(at),
        };
    }
}

/// A judge that is told how long ago each date was, and the dates that it was told of.
struct Aged {
    judge: Judge,
    dates: Vec<Vec<u64>>,
}

impl Aged {
    fn new(program: &Program) -> Self {
        let judge = Judge::new(program);
        let dates = vec![Vec::new(); judge.noted().len()];
        Self { judge, dates }
    }

    fn hear(&mut self, letter: usize, now: u64) -> Option<usize> {
        let ages = |dates: &Vec<u64>| dates.iter().map(|date| now - date).collect();
        let ages: Vec<Vec<u64>> = self.dates.iter().map(ages).collect();
        let (wrong, noted) = self.judge.hear_after(letter, &ages);
        for (dates, noted) in self.dates.iter_mut().zip(noted) {
            *dates = dates[noted.before].to_vec();
            dates.extend(noted.now.then_some(now));
        }
        wrong
    }
}

fn compare(seeds: &[Seed], events: &[(usize, u64)]) -> Result<(), TestCaseError> {
    let parts = formula(seeds);
    let named = parts.iter().map(|part| (part.clone(), String::new())).collect();
    let program = Program::new(named);
    prop_assume!(program.is_ok());
    let program = program.unwrap();
    let (mut judge, mut aged, heard) = (Judge::new(&program), Aged::new(&program), program.hears());
    let (mut date, mut past, mut told) = (0, Vec::new(), Vec::new());
    for &(letter, step) in events {
        date += step;
        let what = happening(letter);
        // Of what it does not hear, a formula is told nothing.
        if let Some(letter) = heard.iter().position(|one| *one == what) {
            past.push((what, date));
            told.push(judge.hear(letter, date));
            prop_assert_eq!(aged.hear(letter, date), *told.last().unwrap());
            prop_assert_eq!(aged.judge.place(), judge.place());
        }
    }
    let meant: Vec<_> = values(&parts, &past).iter().map(|held| blamed(&parts, held)).collect();
    prop_assert_eq!(told, meant);
    Ok(())
}

fn seeds(most: usize) -> impl Strategy<Value = Vec<Seed>> {
    vec(((0u8..17, 0usize..60, 0usize..60), (0u64..3, 0u64..25)), 1..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6_000))]

    #[test]
    fn a_random_formula_is_judged_as_the_definitions_of_its_parts_say(
        seeds in seeds(24),
        events in vec((0usize..8, 0u64..6), 1..40),
    ) {
        compare(&seeds, &events)?;
    }

    /// As codels of a task are heard of: calls and returns by turns, and seldom something else.
    #[test]
    fn so_is_one_of_calls_and_their_returns(
        seeds in seeds(24),
        events in vec((0usize..8, 0u64..6, 0u64..6, proptest::bool::weighted(0.1)), 1..20),
    ) {
        let two = |&(other, before, took, is_other): &(usize, u64, u64, bool)| {
            let other = is_other.then_some((other, 0));
            [Some((0, before)), Some((1, took)), other].into_iter().flatten()
        };
        compare(&seeds, &events.iter().flat_map(two).collect::<Vec<_>>())?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn so_is_one_of_as_many_parts_as_there_may_be(
        seeds in vec(((0u8..17, 0usize..60, 0usize..60), (0u64..3, 0u64..25)), 60..65),
        events in vec((0usize..8, 0u64..6), 1..25),
    ) {
        compare(&seeds, &events)?;
    }
}
