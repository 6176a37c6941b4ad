//! A formula at one moment: one bit for each part, computed from the parts before it and from what
//! held at the event before (Havelund and Rosu, Synthesizing Monitors for Safety Properties, 2002).
//! Only what the event does not tell by itself is computed ([`crate::steps`]).

use std::sync::Arc;

use crate::past::Past;
use crate::program::{Part, Program};
use crate::steps::{Heard, Step, What, has_past, steps};
use crate::value::Value;

/// A formula at one moment.
#[derive(Clone, Debug)]
pub struct Judge {
    /// What is done about each of what it hears.
    heard: Box<[Letter]>,
    /// The steps of all, one after the other.
    steps: Box<[Step]>,
    /// How many times each service of a part runs.
    running: Box<[u32]>,
    pub(crate) pasts: Box<[Past]>,
    /// What held at the event before, of the parts that were computed.
    before: u64,
    /// The parts that another one asks for at the next event.
    asked: u64,
    /// To say what is to blame.
    blames: Arc<Blames>,
}

/// What is done about one thing that is heard.
#[derive(Clone, Copy, Debug, Default)]
struct Letter {
    /// Where its steps are.
    begin: u32,
    end: u32,
    /// The parts that hold by that alone.
    holds: u64,
    /// The formula holds if of these parts those and no others hold after the steps.
    looked_at: u64,
    wanted: u64,
}

/// Because of which of its parts one does not hold.
#[derive(Debug)]
struct Blames {
    parts: Vec<Part>,
    /// For each of what is heard, the value of each part.
    values: Vec<Vec<Value>>,
}

impl Judge {
    /// At the beginning: nothing has happened.
    #[must_use]
    pub fn new(program: &Program) -> Self {
        let parts = program.parts();
        let (mut heard, mut all, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for one in steps(program, &program.hears()) {
            let Heard { steps, holds, looked_at, wanted, values: known } = one;
            let place = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
            let begin = place(all.len());
            all.extend(steps);
            heard.push(Letter { begin, end: place(all.len()), holds, looked_at, wanted });
            values.push(known);
        }
        let past = |part: &Part| part.bounds().filter(|_| has_past(part)).map(Past::new);
        let asked = all.iter().fold(0, |asked, step| match step.what {
            What::Previous(a) => asked | 1 << a,
            _ => asked,
        });
        Self {
            heard: heard.into_boxed_slice(),
            steps: all.into_boxed_slice(),
            running: vec![0; parts.len()].into_boxed_slice(),
            pasts: parts.iter().filter_map(past).collect(),
            before: 0,
            asked,
            blames: Arc::new(Blames { parts: parts.to_vec(), values }),
        }
    }

    /// What is heard under this number happens at this date. Returns the part because of which the
    /// formula does not hold.
    #[inline]
    pub fn hear(&mut self, letter: usize, now: u64) -> Option<usize> {
        let Letter { begin, end, holds, looked_at, wanted } = *self.heard.get(letter)?;
        let mut held = holds;
        for step in self.steps.get(begin as usize..end as usize).unwrap_or_default() {
            let holds = match step.what {
                What::Starts => {
                    let running = &mut self.running[usize::from(step.part)];
                    *running += 1;
                    true
                }
                What::Ends => {
                    let running = &mut self.running[usize::from(step.part)];
                    *running = running.saturating_sub(1);
                    *running > 0
                }
                What::Runs => self.running[usize::from(step.part)] > 0,
                What::Same(a) => a.holds(held),
                What::And(a, b) => a.holds(held) && b.holds(held),
                What::Or(a, b) => a.holds(held) || b.holds(held),
                What::Previous(a) => self.before >> (a & 63) & 1 == 1,
                What::Once(past, a) => {
                    self.pasts[usize::from(past)].goes_on(true, a.holds(held), now)
                }
                What::Historically(past, a) => {
                    !self.pasts[usize::from(past)].goes_on(true, a.holds(held), now)
                }
                What::Since(past, a, b) => {
                    self.pasts[usize::from(past)].goes_on(a.holds(held), b.holds(held), now)
                }
            };
            held |= u64::from(holds) << (step.part & 63);
        }
        self.before = held;
        (held & looked_at != wanted).then(|| self.blames.of(letter, held))
    }

    /// Where it is, apart from dates: two with the same answer to this will judge alike if the
    /// formula has no bounds.
    #[must_use]
    pub fn place(&self) -> (u64, Vec<bool>, Vec<u32>) {
        let any = self.pasts.iter().map(Past::any).collect();
        (self.before & self.asked, any, self.running.to_vec())
    }
}

impl Blames {
    /// The smallest part because of which the last one does not hold, as far as one is to blame.
    #[cold]
    fn of(&self, letter: usize, held: u64) -> usize {
        let values = self.values.get(letter).map_or(&[][..], Vec::as_slice);
        let mut at = self.parts.len() - 1;
        loop {
            at = match self.parts[at] {
                Part::Implies(_, b) => b,
                Part::And(a, b) if self.holds(values, held, a) => b,
                Part::And(a, _) => a,
                _ => return at,
            };
        }
    }

    fn holds(&self, values: &[Value], held: u64, at: usize) -> bool {
        match values[at] {
            Value::Known(holds) => holds,
            Value::Same(other, negated) => match self.parts[other] {
                // Nobody computes it if only its parts are asked for.
                Part::And(a, b) => {
                    let all = self.holds(values, held, a) && self.holds(values, held, b);
                    all != negated
                }
                _ => (held >> other & 1 == 1) != negated,
            },
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use genom_description::model::{CodelIx, Ix as _, ServiceIx};
    use proptest::prelude::*;

    use super::*;
    use crate::{Bounds, Happening};

    /// Of four things that may happen, this one.
    fn happening(letter: usize) -> Happening {
        match letter {
            0 => Happening::Call(CodelIx::new(0)),
            1 => Happening::Call(CodelIx::new(1)),
            2 => Happening::Start(ServiceIx::new(0)),
            _ => Happening::End(ServiceIx::new(0)),
        }
    }

    /// A part that refers to some of the `at` before it.
    fn part(at: usize, (kind, a, b): (u8, usize, usize), (least, width): (u64, u64)) -> Part {
        let ever = width > 20;
        let bounds = Bounds { least, most: if ever { u64::MAX } else { least + width.max(1) } };
        let heard = |letter: usize| Part::Happens(vec![happening(letter % 4)]);
        if at == 0 {
            return heard(a);
        }
        let (a, b) = (a % at, b % at);
        match kind {
            0 => heard(b),
            1 => Part::Runs(ServiceIx::new(0)),
            2 => Part::Constant(b.is_multiple_of(2)),
            3 => Part::Not(a),
            4 => Part::And(a, b),
            5 => Part::Or(a, b),
            6 => Part::Implies(a, b),
            7 => Part::Previous(a),
            8 => Part::Once(bounds, a),
            9 => Part::Historically(bounds, a),
            _ => Part::Since(bounds, a, b),
        }
    }

    /// The values of all parts at the last of these events, by their definitions.
    fn values(parts: &[Part], events: &[(Happening, u64)]) -> Vec<Vec<bool>> {
        let mut all: Vec<Vec<bool>> = Vec::new();
        for (now, (what, date)) in events.iter().enumerate() {
            let mut held: Vec<bool> = Vec::new();
            for (at, part) in parts.iter().enumerate() {
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
                debug_assert_eq!(held.len(), at + 1);
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

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        #[test]
        fn a_random_formula_is_judged_as_the_definitions_of_its_parts_say(
            kinds in proptest::collection::vec(
                ((0u8..11, 0usize..20, 0usize..20), (0u64..3, 0u64..25)), 1..20),
            events in proptest::collection::vec((0usize..4, 0u64..6), 1..40),
        ) {
            let parts: Vec<Part> = kinds.iter().enumerate()
                .map(|(at, (kind, bounds))| part(at, *kind, *bounds)).collect();
            let named = parts.iter().map(|part| (part.clone(), String::new())).collect();
            let program = Program::new(named);
            prop_assume!(program.is_ok());
            let program = program.unwrap();
            let (mut judge, heard) = (Judge::new(&program), program.hears());
            let mut date = 0;
            let mut past = Vec::new();
            let mut told = Vec::new();
            for (letter, step) in events {
                date += step;
                let what = happening(letter);
                // Of what it does not hear, a formula is told nothing.
                if let Some(letter) = heard.iter().position(|one| *one == what) {
                    past.push((what, date));
                    told.push(judge.hear(letter, date));
                }
            }
            let values = values(&parts, &past);
            let meant: Vec<_> = values.iter().map(|held| blamed(&parts, held)).collect();
            prop_assert_eq!(told, meant);
        }
    }

    #[test]
    fn what_an_event_tells_by_itself_takes_no_step() {
        let within = Bounds { least: 0, most: 9 };
        let parts = |more: Vec<Part>| {
            let first = [Part::Happens(vec![happening(0)]), Part::Happens(vec![happening(1)])];
            first.into_iter().chain(more).map(|part| (part, String::new())).collect()
        };
        let counts = |more: Vec<Part>| {
            let judge = Judge::new(&Program::new(parts(more)).unwrap());
            judge.heard.iter().map(|one| one.end - one.begin).collect::<Vec<_>>()
        };
        // `b -> once[0, 9] a`: `a` is noted, and looked up at `b`.
        assert_eq!(counts(vec![Part::Once(within, 0), Part::Implies(1, 2)]), [1, 1]);
        // `a -> once[0, 9] a` always holds.
        assert_eq!(counts(vec![Part::Once(within, 0), Part::Implies(0, 2)]), [0, 0]);
        // Of what always or never happens, the past is known: `a or b` is all that is heard.
        assert_eq!(counts(vec![Part::Or(0, 1), Part::Historically(within, 2)]), [0, 0]);
        // `(b -> previous a) and (b -> once[0, 9] a)`: what holds where another part does takes no
        // step, nor do the two together.
        let both = vec![
            Part::Previous(0),
            Part::Implies(1, 2),
            Part::Once(within, 0),
            Part::Implies(1, 4),
            Part::And(3, 5),
        ];
        assert_eq!(counts(both), [1, 2]);
    }

    #[test]
    fn a_formula_that_asks_for_a_part_and_for_its_contrary_never_holds() {
        let parts = vec![
            Part::Happens(vec![happening(0)]),
            Part::Previous(0),
            Part::Runs(ServiceIx::new(0)),
            Part::And(1, 2),
            Part::Not(1),
            Part::And(3, 4),
        ];
        let parts = parts.into_iter().map(|part| (part, String::new())).collect();
        let program = Program::new(parts).unwrap();
        let (mut judge, heard) = (Judge::new(&program), program.hears());
        for (what, at) in [2, 0, 0, 3, 2].into_iter().zip(0u64..) {
            let letter = heard.iter().position(|one| *one == happening(what)).unwrap();
            assert!(judge.hear(letter, at).is_some(), "{at}");
        }
    }
}
