//! What is noted for formulas with bounds, compared with the judge of the runtime.

#![allow(clippy::unwrap_used)]

use genom_description::model::{CodelIx, Ix as _, ServiceIx};
use genom_runtime::{Happening, Part, Program};

use super::*;
use genom_timing::Random;

fn happening(number: usize) -> Happening {
    match number {
        0 => Happening::Call(CodelIx::new(0)),
        1 => Happening::Call(CodelIx::new(1)),
        2 => Happening::Start(ServiceIx::new(0)),
        _ => Happening::End(ServiceIx::new(0)),
    }
}

fn formula(random: &mut Random) -> Program {
    let mut parts: Vec<Part> = (0..3).map(|at| Part::Happens(vec![happening(at)])).collect();
    parts.push(Part::Runs(ServiceIx::new(0)));
    for at in parts.len()..parts.len() + 3 + random.below(9) {
        let (a, b) = (random.below(at), random.below(at));
        let date = random.below(9) as u64;
        let bounds = match random.below(5) {
            0 => ANY,
            1 => Bounds { least: date.max(1), most: u64::MAX },
            _ => Bounds { least: 0, most: date },
        };
        parts.push(match random.below(8) {
            0 => Part::Not(a),
            1 => Part::And(a, b),
            2 => Part::Or(a, b),
            3 => Part::Implies(a, b),
            4 => Part::Previous(a),
            5 => Part::Historically(bounds, a),
            6 => Part::Since(bounds, a, b),
            _ => Part::Once(bounds, a),
        });
    }
    Program::new(parts.into_iter().map(|part| (part, String::new())).collect()).unwrap()
}

#[test]
fn random_runs_are_judged_by_clocks_as_the_runtime_judges_them_by_dates() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut broken, mut kept) = (0, 0);
    for _ in 0..4_000 {
        let program = formula(&mut random);
        let mut judge = Judge::new(&program);
        let heard = program.hears();
        let mut moment =
            Moment { judge: judge.clone(), clocks: Vec::new(), zone: Zone::point(&[]) };
        let mut ages: Vec<i64> = Vec::new();
        let mut date = 0u64;
        for _ in 0..30 {
            let step = random.below(5) as u64;
            date += step;
            ages.iter_mut().for_each(|age| *age += i64::try_from(step).unwrap());
            moment.zone = Zone::point(&ages);
            let letter = random.below(heard.len());
            let all = moment.hear(letter).unwrap();
            let [(next, wrong)] = &all[..] else { panic!("{} ways", all.len()) };
            assert_eq!(*wrong, judge.hear(letter, date).is_some(), "{program:?}");
            *(if *wrong { &mut broken } else { &mut kept }) += 1;
            assert_eq!(next.judge.place(), judge.place());
            moment = next.clone();
            ages = (1..=moment.clocks.len()).map(|at| moment.zone.most(at).unwrap()).collect();
        }
    }
    assert!(broken > 10_000 && kept > 10_000, "{broken} broken, {kept} kept");
}

#[test]
fn a_zone_is_cut_where_a_bound_tells_its_dates_apart() {
    let called = |codel: usize| Part::Happens(vec![Happening::Call(CodelIx::new(codel))]);
    let parts =
        [called(0), called(1), Part::Once(Bounds { least: 0, most: 9 }, 0), Part::Implies(1, 2)];
    let parts = parts.into_iter().map(|part| (part, String::new())).collect();
    let program = Program::new(parts).unwrap();
    let letter = |codel: usize| {
        let what = Happening::Call(CodelIx::new(codel));
        program.hears().iter().position(|one| *one == what).unwrap()
    };
    let judge = Judge::new(&program);
    let first = Moment { judge, clocks: Vec::new(), zone: Zone::point(&[]) };
    let mut after = first.hear(letter(0)).unwrap().remove(0).0;
    after.zone.up();
    let all = after.hear(letter(1)).unwrap();
    let told: Vec<(Option<i64>, bool)> =
        all.iter().map(|(moment, wrong)| (moment.zone.most(1), *wrong)).collect();
    assert_eq!(told, [(Some(9), false), (None, true)]);
}
