//! A formula at one moment: a bit for each part, of what held before and of what holds now (Havelund
//! and Rosu, Synthesizing Monitors for Safety Properties, 2002). What the event tells by itself is
//! put in by masks; only the rest is computed ([`crate::steps`]).

use std::borrow::Cow;
use std::sync::Arc;

use crate::past::{Bounds, Dates, Past};
use crate::program::{Part, Program};
use crate::step::{What, says};
use crate::steps::{Letter, letters};
use crate::value::{Value, both_of};

/// A formula at one moment.
#[derive(Clone, Debug)]
pub struct Judge {
    letters: Arc<[Letter]>,
    pub(crate) state: State,
}

/// Where a formula is.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// The bits of parts that the next event depends on ([`crate::step`]).
    memory: u64,
    pub(crate) noted: Noted,
    /// To say what is to blame.
    blames: Arc<Blames>,
}

/// What is noted beside bits.
#[derive(Clone, Debug)]
pub(crate) struct Noted {
    /// Of each part with bounds.
    pub(crate) pasts: Box<[Past]>,
    /// Of those that need more dates than one.
    pub(crate) dates: Box<[Dates]>,
    /// How many times each service of a part runs.
    running: Box<[u32]>,
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
        let (letters, values): (Vec<Letter>, _) = letters(program).into_iter().unzip();
        let noted = Noted::new(parts);
        let blames = Arc::new(Blames { parts: parts.to_vec(), values });
        Self { letters: letters.into(), state: State { memory: 0, noted, blames } }
    }

    /// What is done about each of what it hears. Who keeps these at hand has to look nothing up.
    #[must_use]
    pub fn letters(&self) -> &[Letter] {
        &self.letters
    }

    /// What is heard under this number happens at this date. Returns the part because of which the
    /// formula does not hold.
    #[inline]
    pub fn hear(&mut self, number: usize, now: u64) -> Option<usize> {
        self.state.hear(self.letters.get(number)?, now)
    }

    /// The same, with one of its [`letters`](Self::letters).
    #[inline]
    pub fn hear_letter(&mut self, letter: &Letter, now: u64) -> Option<usize> {
        self.state.hear(letter, now)
    }

    /// Where it is, apart from dates: two with the same answer to this will judge alike if the
    /// formula has no bounds. For each part with dates it has their number.
    #[must_use]
    pub fn place(&self) -> (u64, Vec<usize>, Vec<u32>) {
        let noted = &self.state.noted;
        let counts = noted.pasts.iter().map(|past| self.state.dates_of(past).len()).collect();
        (self.state.memory, counts, noted.running.to_vec())
    }
}

impl State {
    #[inline]
    fn hear(&mut self, letter: &Letter, now: u64) -> Option<usize> {
        let (mut bits, mut next) = (self.memory & letter.from | letter.set, letter.next);
        let pasts = &mut self.noted.pasts;
        each(letter.gone, pasts, |past| past.note(false, now));
        each(letter.noted, pasts, |past| past.note(true, now));
        each(letter.looked, pasts, |past| {
            bits |= u64::from(past.is_within(now)) << (past.part & 63);
        });
        for step in &*letter.steps {
            let fires = bits & step.mask == step.want;
            let turns = match step.what {
                What::Turn => fires,
                other => self.noted.step(other, fires, now),
            };
            let turns = u64::from(turns).wrapping_neg();
            bits ^= step.turns & turns;
            next |= step.keeps & turns;
        }
        self.memory = bits & letter.stays | next;
        (bits & letter.looked_at != letter.wanted).then(|| self.blames.of(letter.number, bits))
    }

    /// The dates that are noted for a part, the first one first; for any time, a bit says it all.
    pub(crate) fn dates_of(&self, past: &Past) -> Cow<'_, [u64]> {
        let list = past.list.and_then(|list| self.noted.dates.get(usize::from(list)));
        match list {
            Some(list) => list.all().into(),
            None if past.bounds() == Bounds::EVER => Cow::default(),
            None => past.date().into_iter().collect(),
        }
    }
}

/// Each of these, by number.
#[inline]
fn each(mut numbers: u64, pasts: &mut [Past], mut done: impl FnMut(&mut Past)) {
    while numbers != 0 {
        if let Some(past) = pasts.get_mut(numbers.trailing_zeros() as usize) {
            done(past);
        }
        numbers &= numbers - 1;
    }
}

impl Noted {
    fn new(parts: &[Part]) -> Self {
        let (mut pasts, mut dates) = (Vec::new(), Vec::new());
        for (part, bounds) in (0..).zip(parts).filter_map(|(at, part)| Some((at, part.bounds()?))) {
            let list = bounds.of_many_dates().then(|| u8::try_from(dates.len()).unwrap_or(u8::MAX));
            dates.extend(list.map(|_| Dates::new(bounds)));
            pasts.push(Past::new(part, bounds, list));
        }
        let running = vec![0; parts.len()].into();
        Self { pasts: pasts.into(), dates: dates.into(), running }
    }

    /// Does what a step does beside changing bits; whether these change.
    #[cold]
    #[inline(never)]
    fn step(&mut self, what: What, fires: bool, now: u64) -> bool {
        match what {
            What::Turn => fires,
            What::Look(at) => {
                let past = &self.pasts[usize::from(at)];
                let list = past.list.and_then(|list| self.dates.get(usize::from(list)));
                list.map_or_else(|| past.is_within(now), |dates| dates.are_within(now))
            }
            What::Note(at, is_there) => {
                if fires {
                    let past = &mut self.pasts[usize::from(at)];
                    past.note(is_there, now);
                    let list = past.list.and_then(|list| self.dates.get_mut(usize::from(list)));
                    list.into_iter().for_each(|dates| dates.note(is_there, now));
                }
                false
            }
            What::Starts(part) => {
                self.running[usize::from(part)] += 1;
                false
            }
            What::Ends(part) => {
                let running = &mut self.running[usize::from(part)];
                *running = running.saturating_sub(1);
                *running > 0
            }
        }
    }
}

impl Blames {
    /// The smallest part because of which the last one does not hold, as far as one is to blame.
    #[cold]
    #[inline(never)]
    fn of(&self, letter: usize, bits: u64) -> usize {
        let values = self.values.get(letter).map_or(&[][..], Vec::as_slice);
        let mut at = self.parts.len() - 1;
        loop {
            at = match self.parts[at] {
                Part::Implies(_, b) => b,
                Part::And(a, b) if self.holds(values, bits, values[a]) => b,
                Part::And(a, _) => a,
                _ => return at,
            };
        }
    }

    /// Nobody computes the bits of parts that others do not ask for.
    fn holds(&self, values: &[Value], bits: u64, value: Value) -> bool {
        let (at, contrary) = match value {
            Value::Known(holds) => return holds,
            Value::Same(at, contrary) => (at, contrary),
        };
        let part = &self.parts[at];
        let is_set = match both_of(part, values) {
            Some((a, b, _)) => self.holds(values, bits, a) && self.holds(values, bits, b),
            None => bits >> at & 1 == 1,
        };
        (is_set == says(part)) != contrary
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{Bounds, Happening};
    use genom_description::model::{CodelIx, Ix as _, ServiceIx};

    /// Of four things that may happen, this one.
    fn happening(letter: usize) -> Happening {
        match letter {
            0 => Happening::Call(CodelIx::new(0)),
            1 => Happening::Call(CodelIx::new(1)),
            2 => Happening::Start(ServiceIx::new(0)),
            _ => Happening::End(ServiceIx::new(0)),
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
            let dates = |one: &Letter| (one.gone | one.noted | one.looked).count_ones() as usize;
            judge.letters.iter().map(|one| dates(one) + one.steps.len()).collect::<Vec<_>>()
        };
        // `b -> once[0, 9] a`: `a` is noted, and looked up at `b`.
        assert_eq!(counts(vec![Part::Once(within, 0), Part::Implies(1, 2)]), [1, 1]);
        // `a -> once[0, 9] a` always holds.
        assert_eq!(counts(vec![Part::Once(within, 0), Part::Implies(0, 2)]), [0, 0]);
        // Of what always or never happens, the past is known: `a or b` is all that is heard.
        assert_eq!(counts(vec![Part::Or(0, 1), Part::Historically(within, 2)]), [0, 0]);
        // `(b -> previous a) and (b -> once[0, 9] a)`: what holds where another part does takes no
        // step, nor do the two together, nor what was at the event before.
        let both = vec![
            Part::Previous(0),
            Part::Implies(1, 2),
            Part::Once(within, 0),
            Part::Implies(1, 4),
            Part::And(3, 5),
        ];
        assert_eq!(counts(both), [1, 1]);
        // `b -> (not a) since b`: without bounds it is a bit that is set or not.
        let ever = Part::Since(Bounds::EVER, 2, 1);
        assert_eq!(counts(vec![Part::Not(0), ever, Part::Implies(1, 3)]), [0, 0]);
        // `(b -> once[0, 9] a) and not historically[0, 9] not a`: what is the same is looked up once.
        let twice = vec![
            Part::Once(within, 0),
            Part::Implies(1, 2),
            Part::Not(0),
            Part::Historically(within, 4),
            Part::Not(5),
            Part::And(3, 6),
        ];
        assert_eq!(counts(twice), [1, 1]);
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
