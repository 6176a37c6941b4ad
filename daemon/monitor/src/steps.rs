//! What of a formula depends on more than what happens.
//!
//! By what happens alone, many parts hold or do not: `codel a is called` does, `once[0, 1s] a` holds
//! where `a` does; and others hold where another part does: `a -> b` where `b` does, if it is `a` that
//! happens. What is noted often follows, too: of `previous a`, `once a` and `b since a` it is one bit,
//! which is set or not wherever `a` and `b` are known. All these bits are set at once, by masks. So
//! for each of what is heard there are steps of their own, for what remains: dates that are noted or
//! looked at then, and bits that depend on others. What nobody asks for takes no step.

use std::sync::Arc;

use genom_description::model::ServiceIx;

use crate::happening::Happening;
use crate::literals::Literals;
use crate::needed::needed;
use crate::past::Bounds;
use crate::program::{Part, Program};
use crate::step::{Step, What};
use crate::value::{Value, both_of, values};

/// What is done about one thing that a formula hears. Parts are bits ([`crate::step`]).
#[derive(Clone, Debug, Default)]
pub struct Letter {
    /// The number under which it is heard.
    pub(crate) number: usize,
    /// Bits that are as they were after the event before.
    pub(crate) from: u64,
    /// Bits that are set by this alone.
    pub(crate) set: u64,
    /// Parts with bounds, by their numbers: what was noted is gone; something is noted now; and
    /// whether that is within the bounds is looked at.
    pub(crate) gone: u64,
    pub(crate) noted: u64,
    pub(crate) looked: u64,
    /// What depends on bits.
    pub(crate) steps: Arc<[Step]>,
    /// The formula holds if, after the steps, of these bits those and no others are set.
    pub(crate) looked_at: u64,
    pub(crate) wanted: u64,
    /// After that, bits that stay for the next event, and others that are set at it.
    pub(crate) stays: u64,
    pub(crate) next: u64,
}

/// For each of what a program hears: what is done about it, and the value of each part.
pub(crate) fn letters(program: &Program) -> Vec<(Letter, Vec<Value>)> {
    let (parts, heard) = (program.parts(), program.hears());
    let values = values(program, &heard);
    let needed = needed(program, &values);
    let one = |((number, what), (values, asked)): ((usize, Happening), (Vec<Value>, u64))| {
        let letter = Letter { number, ..Letter::default() };
        let mut all = Making { parts, values, letter, steps: Vec::new() };
        let mut number = 0;
        for (at, part) in parts.iter().enumerate() {
            let is = |set: u64| set >> at & 1 == 1;
            match part {
                Part::Runs(service) if is(needed.noted) => all.runs(at, *service, what),
                Part::Previous(_) if is(needed.noted) => all.letter.from |= 1 << at,
                _ if part.bounds().is_some() && is(needed.noted) => {
                    all.past(at, part, number, is(asked));
                }
                _ if is(asked) => all.now(at, part),
                _ => {}
            }
            number += u8::from(part.bounds().is_some());
        }
        // What the next event asks for is noted when all bits are there.
        for (at, part) in parts.iter().enumerate() {
            match part {
                Part::Previous(a) if needed.noted >> at & 1 == 1 => all.previous(at, *a),
                _ => {}
            }
        }
        all.judged();
        all.letter.steps = all.steps.into();
        (all.letter, all.values)
    };
    heard.into_iter().enumerate().zip(values.into_iter().zip(needed.values)).map(one).collect()
}

struct Making<'p> {
    parts: &'p [Part],
    values: Vec<Value>,
    letter: Letter,
    steps: Vec<Step>,
}

impl Making<'_> {
    /// What has to be so that a value is the wanted one.
    fn literals(&self, value: Value, wanted: bool) -> Option<Literals> {
        Literals::of(self.parts, &self.values, [(value, wanted)])
    }

    /// A step that is done if these bits are so; none if they never are.
    fn step(&mut self, if_so: Option<Literals>, turns: u64, keeps: u64, what: What) {
        let step = |Literals { mask, want }| Step { mask, want, turns, keeps, what };
        self.steps.extend(if_so.map(step));
    }

    /// The bit of a part that depends on others now.
    fn now(&mut self, at: usize, part: &Part) {
        let Some((a, b, _)) = both_of(part, &self.values) else { return };
        let both = Literals::of(self.parts, &self.values, [(a, true), (b, true)]);
        self.step(both, 1 << at, 0, What::Turn);
    }

    /// `previous`: the next event is told the value of now.
    fn previous(&mut self, at: usize, a: usize) {
        match self.values[a] {
            Value::Known(holds) => self.letter.next |= u64::from(holds) << at,
            value => self.step(self.literals(value, true), 0, 1 << at, What::Turn),
        }
    }

    fn runs(&mut self, at: usize, service: ServiceIx, what: Happening) {
        let (own, part) = (1 << at, u8::try_from(at).unwrap_or(u8::MAX));
        self.letter.stays |= own;
        let always = Some(Literals::default());
        if what == Happening::Start(service) {
            self.letter.set |= own;
            self.step(always, 0, 0, What::Starts(part));
        } else if what == Happening::End(service) {
            self.step(always, own, 0, What::Ends(part));
        } else {
            self.letter.from |= own;
        }
    }

    /// A part with bounds, of this number among them, and whether its value is asked for.
    fn past(&mut self, at: usize, part: &Part, number: u8, asked: bool) {
        let Some((noted, bounds)) = part.noted() else { return };
        let own = 1 << at;
        let (stays, holds) = noted.values(&self.values, bounds);
        let (gone, noted) = (self.literals(stays, false), self.literals(holds, true));
        if bounds == Bounds::EVER {
            // One bit: it holds if anything was ever noted, and did not go since.
            self.letter.stays |= own;
            if stays != Value::Known(false) {
                self.letter.from |= own;
            }
            if holds == Value::Known(true) {
                self.letter.set |= own;
                return;
            }
            if stays != Value::Known(false) {
                self.step(gone.and_then(|gone| gone.and(at, true)), own, 0, What::Turn);
            }
            self.step(noted.and_then(|noted| noted.and(at, false)), own, 0, What::Turn);
            return;
        }
        let looks = asked && matches!(self.values[at], Value::Same(..));
        let known = |value| matches!(value, Value::Known(_));
        if known(stays) && known(holds) && !bounds.of_many_dates() {
            let of = |is_so: bool| u64::from(is_so) << number;
            self.letter.gone |= of(stays == Value::Known(false));
            self.letter.noted |= of(holds == Value::Known(true));
            self.letter.looked |= of(looks);
            return;
        }
        self.step(gone, 0, 0, What::Note(number, false));
        self.step(noted, 0, 0, What::Note(number, true));
        if looks {
            self.step(Some(Literals::default()), own, 0, What::Look(number));
        }
    }

    /// The bits on which it depends whether the last part holds.
    fn judged(&mut self) {
        let Some(last) = self.values.last() else { return };
        // If it never does, a bit is wanted that is not looked at.
        let never = Literals { mask: 0, want: 1 };
        let Literals { mask, want } = self.literals(*last, true).unwrap_or(never);
        (self.letter.looked_at, self.letter.wanted) = (mask, want);
    }
}
