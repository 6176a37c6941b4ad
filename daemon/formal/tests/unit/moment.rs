//! What is noted for formulas with bounds, compared with the judge of the runtime.

#![allow(clippy::unwrap_used)]

use genom_description::model::{CodelIx, Ix as _, ServiceIx};
use genom_runtime::{Happening, Part, Program};

use super::*;
use genom_timing::{Guards, Random};

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
        let width = 1 + random.below(6) as u64;
        let bounds = match random.below(6) {
            0 => Bounds { least: 0, most: u64::MAX },
            1 => Bounds { least: date.max(1), most: u64::MAX },
            2 | 3 => Bounds { least: 0, most: date },
            _ => Bounds { least: date.max(1), most: date.max(1) + width },
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
    let (mut broken, mut kept, mut most) = (0, 0, 0);
    for _ in 0..4_000 {
        let program = formula(&mut random);
        let mut judge = Judge::new(&program);
        let heard = program.hears();
        let mut moment = Moment::at(judge.clone(), Vec::new(), Zone::point(&[]));
        let mut ages: Vec<i64> = Vec::new();
        let mut date = 0u64;
        for _ in 0..30 {
            let step = random.below(5) as u64;
            date += step;
            ages.iter_mut().for_each(|age| *age += i64::try_from(step).unwrap());
            moment.zone = Zone::point(&ages);
            let letter = random.below(heard.len());
            let all = moment.hear(letter);
            let [(next, wrong)] = &all[..] else { panic!("{} ways", all.len()) };
            assert_eq!(*wrong, judge.hear(letter, date).is_some(), "{program:?}");
            *(if *wrong { &mut broken } else { &mut kept }) += 1;
            assert_eq!(next.judge.place(), judge.place());
            moment = next.clone();
            most = most.max(moment.clocks.len());
            ages = (1..=moment.clocks.len()).map(|at| moment.zone.most(at).unwrap()).collect();
        }
    }
    assert!(broken > 10_000 && kept > 10_000, "{broken} broken, {kept} kept");
    assert!(most > 8, "{most} dates");
}

/// Lets up to four units of time pass as a search does, with all values that no bound tells apart.
fn passed(moment: &mut Moment) {
    let count = moment.clocks.len();
    let with_step: Vec<Option<usize>> = [None].into_iter().chain((1..=count).map(Some)).collect();
    let mut zone = moment.zone.select(&with_step);
    zone.up();
    assert!(zone.at_most(1, 4));
    let guards =
        |most: u64, passes| Guards { least: Some(bound(most)), most: Some(bound(most)), passes };
    let of_dates = moment.clocks.iter().map(|clock| match clock {
        Clock::Noted(_, most) => guards(*most, true),
        other => panic!("{other:?}"),
    });
    zone.extrapolate(&[guards(4, false)].into_iter().chain(of_dates).collect::<Vec<_>>());
    moment.zone = zone.select(&(2..2 + count).map(Some).collect::<Vec<_>>());
}

/// The same with a clock beside each, which stays when its date is forgotten.
fn twice(moment: &Moment) -> Moment {
    let all = || (1..=moment.clocks.len()).map(Some);
    let zone = moment.zone.select(&all().chain(all()).collect::<Vec<_>>());
    let others = moment.clocks.iter().map(|_| Clock::Followed(0));
    let clocks = others.chain(moment.clocks.iter().copied()).collect();
    let trail = Trail::of(moment.clocks.len());
    Moment { judge: moment.judge.clone(), clocks, zone, trail }
}

#[test]
fn each_part_of_a_zone_is_judged_as_the_runtime_judges_all_dates_in_it() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut cuts, mut broken) = (0, 0);
    for _ in 0..4_000 {
        let program = formula(&mut random);
        let mut judge = Judge::new(&program);
        let heard = program.hears();
        let mut moment = Moment::at(judge.clone(), Vec::new(), Zone::point(&[]));
        let (mut date, mut ages) = (0u64, Vec::<i64>::new());
        for _ in 0..30 {
            let step = random.below(5);
            date += step as u64;
            ages.iter_mut().for_each(|age| *age += i64::try_from(step).unwrap());
            passed(&mut moment);
            let letter = random.below(heard.len());
            let all = twice(&moment).hear(letter);
            cuts += usize::from(all.len() > 1);
            let count = ages.len();
            let before: Vec<Option<usize>> = (1..=count).map(Some).collect();
            let is_in = |(part, _): &&(Moment, bool)| {
                part.zone.select(&before).includes(&Zone::point(&ages))
            };
            let parts: Vec<&(Moment, bool)> = all.iter().filter(is_in).collect();
            let [(part, wrong)] = parts[..] else { panic!("{ages:?} in {} parts", parts.len()) };
            assert_eq!(*wrong, judge.hear(letter, date).is_some(), "{program:?}");
            assert_eq!(part.judge.place(), judge.place(), "{program:?}");
            broken += usize::from(*wrong);
            for (date, age) in &part.trail.ages {
                let holds = match *age {
                    Age::Least(least) => ages[*date] >= bound(least),
                    Age::Most(most) => ages[*date] <= bound(most),
                };
                assert!(holds, "{ages:?} {:?}", part.trail);
            }
            // The dates that are left, in the run and in all that may have happened.
            let mut run = Moment { zone: Zone::point(&ages), ..moment };
            run = run.hear(letter).remove(0).0;
            ages = (1..=run.clocks.len()).map(|at| run.zone.most(at).unwrap()).collect();
            let after: Vec<Option<usize>> = (count + 1..=part.clocks.len()).map(Some).collect();
            moment = Moment { zone: part.zone.select(&after), ..run };
        }
    }
    assert!(cuts > 1_000 && broken > 1_000, "{cuts} cuts, {broken} broken");
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
    let first = Moment::at(judge, Vec::new(), Zone::point(&[]));
    let mut after = first.hear(letter(0)).remove(0).0;
    after.zone.up();
    let all = after.hear(letter(1));
    let told: Vec<(Option<i64>, bool)> =
        all.iter().map(|(moment, wrong)| (moment.zone.most(1), *wrong)).collect();
    assert_eq!(told, [(Some(9), false), (None, true)]);
}
