//! What of a formula depends on more than what happens.
//!
//! By what happens alone, many parts hold or do not: `codel a is called` does, `once[0, 1s] a` holds
//! where `a` does; and others hold where another part does: `a -> b` where `b` does, if it is `a` that
//! happens. So for each of what is heard there are steps of their own, for the parts whose values are
//! to be looked up or noted then, and for no others: nobody asks for the values of all of them, and
//! not all that happens is asked for later.

use crate::happening::Happening;
use crate::program::{Part, Program};
use crate::value::{Value, values};

/// One step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The part whose value it finds.
    pub(crate) part: u8,
    pub(crate) what: What,
}

/// How a value is found. Services and dates are given by number.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// The service of this part starts.
    Starts,
    /// It ends.
    Ends,
    Runs,
    /// The part holds where another one does.
    Same(Of),
    And(Of, Of),
    Or(Of, Of),
    Previous(u8),
    Once(u8, Of),
    Historically(u8, Of),
    Since(u8, Of, Of),
}

/// The value of a part, or its contrary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Of(u8);

impl Of {
    const NOT: u8 = 0x80;

    fn new(part: usize, negated: bool) -> Self {
        Self(small(part) | if negated { Self::NOT } else { 0 })
    }

    /// Its value, if these parts hold.
    #[inline]
    pub(crate) fn holds(self, held: u64) -> bool {
        (held >> (self.0 & 63) & 1 == 1) != (self.0 & Self::NOT != 0)
    }
}

/// What one thing that is heard does to a formula.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heard {
    pub(crate) steps: Vec<Step>,
    /// The parts that hold by that alone, as bits.
    pub(crate) holds: u64,
    /// The formula holds if, after the steps, of these parts those and no others hold.
    pub(crate) looked_at: u64,
    pub(crate) wanted: u64,
    /// The value of each part.
    pub(crate) values: Vec<Value>,
}

/// For each of what a program hears: what it does.
pub(crate) fn steps(program: &Program, heard: &[Happening]) -> Vec<Heard> {
    let parts = program.parts();
    let values = values(program, heard);
    let needed = needed(parts, heard, &values);
    let one = |((what, values), needed): ((&Happening, Vec<Value>), Needed)| {
        let mut all = Heard::default();
        let mut pasts = 0;
        for (at, part) in parts.iter().enumerate() {
            let past = pasts;
            pasts += u8::from(has_past(part));
            let step = match values[at] {
                Value::Known(holds) => {
                    all.holds |= u64::from(holds) << at;
                    None
                }
                Value::Same(other, negated) if other != at => {
                    let asked = needed.asked[at];
                    asked.then(|| What::Same(Of::new(other, negated)))
                }
                Value::Same(..) => {
                    needed.value[at].then(|| step(part, *what, past, &values)).flatten()
                }
            };
            let noted = step.is_none() && needed.notes[at] && notes(part, *what, &values);
            let note = noted.then(|| self::step(part, *what, past, &values)).flatten();
            let what = step.or(note);
            all.steps.extend(what.map(|what| Step { part: small(at), what }));
        }
        (all.looked_at, all.wanted) = wanted(parts, &values);
        all.values = values;
        all
    };
    heard.iter().zip(values).zip(needed).map(one).collect()
}

/// Whether dates are noted for it.
pub(crate) fn has_past(part: &Part) -> bool {
    matches!(part, Part::Once(..) | Part::Historically(..) | Part::Since(..))
}

fn small(at: usize) -> u8 {
    u8::try_from(at).unwrap_or(u8::MAX)
}

fn step(part: &Part, what: Happening, past: u8, values: &[Value]) -> Option<What> {
    // What is known is a bit that is there.
    let of = |at: usize| match values[at] {
        Value::Known(_) => Of::new(at, false),
        Value::Same(other, negated) => Of::new(other, negated),
    };
    let not = |of: Of| Of(of.0 ^ Of::NOT);
    Some(match *part {
        Part::Constant(_) | Part::Happens(_) => return None,
        Part::Runs(service) if what == Happening::Start(service) => What::Starts,
        Part::Runs(service) if what == Happening::End(service) => What::Ends,
        Part::Runs(_) => What::Runs,
        Part::Not(a) => What::Same(not(of(a))),
        Part::And(a, b) => What::And(of(a), of(b)),
        Part::Or(a, b) => What::Or(of(a), of(b)),
        Part::Implies(a, b) => What::Or(not(of(a)), of(b)),
        Part::Previous(a) => What::Previous(small(a)),
        Part::Once(_, a) => What::Once(past, of(a)),
        Part::Historically(_, a) => What::Historically(past, not(of(a))),
        Part::Since(_, a, b) => What::Since(past, of(a), of(b)),
    })
}

/// The parts on which it depends whether the last one holds, and those of them that have to.
fn wanted(parts: &[Part], values: &[Value]) -> (u64, u64) {
    let (mut hold, mut fail) = (0u64, 0u64);
    for (at, holds) in leaves(parts, values) {
        *(if holds { &mut hold } else { &mut fail }) |= 1 << at;
    }
    // Of no part, a bit is wanted: where one would have to hold and not to hold.
    if hold & fail == 0 { (hold | fail, hold) } else { (0, 1) }
}

/// The parts that all have to hold, or not to hold, so that the last one does.
fn leaves(parts: &[Part], values: &[Value]) -> Vec<(usize, bool)> {
    let (mut left, mut leaves) = (vec![parts.len() - 1], Vec::new());
    while let Some(at) = left.pop() {
        match values[at] {
            Value::Known(true) => {}
            // Its bit is not set.
            Value::Known(false) => leaves.push((at, true)),
            Value::Same(other, true) => leaves.push((other, false)),
            Value::Same(other, false) => match parts[other] {
                Part::And(a, b) => left.extend([a, b]),
                _ => leaves.push((other, true)),
            },
        }
    }
    leaves
}

/// Whether what happens changes what is noted for a part.
fn notes(part: &Part, what: Happening, values: &[Value]) -> bool {
    let is = |at: usize, known: bool| values[at] == Value::Known(known);
    match part {
        Part::Runs(service) => {
            what == Happening::Start(*service) || what == Happening::End(*service)
        }
        Part::Once(_, a) => !is(*a, false),
        Part::Historically(_, a) => !is(*a, true),
        Part::Since(_, a, b) => !is(*a, true) || !is(*b, false),
        _ => false,
    }
}

/// Whether a part depends on this one of its parts: where the second part of `since` holds now, what
/// held before says no more, if only the last date is kept.
fn asks(part: &Part, of: usize, values: &[Value]) -> bool {
    match part {
        Part::Since(bounds, a, b) => {
            let now = bounds.least == 0 && values[*b] == Value::Known(true);
            !now || of != *a
        }
        _ => true,
    }
}

/// What of each part is needed when one thing is heard.
#[derive(Clone, Debug)]
struct Needed {
    /// Its value, of those that are none of another part.
    value: Vec<bool>,
    /// A bit of its own: it is asked for at what is heard next.
    asked: Vec<bool>,
    /// What is noted for it.
    notes: Vec<bool>,
}

/// For each of what is heard, what is needed at it, or because of it later.
fn needed(parts: &[Part], heard: &[Happening], values: &[Vec<Value>]) -> Vec<Needed> {
    let none = vec![false; parts.len()];
    let none = Needed { value: none.clone(), asked: none.clone(), notes: none };
    let mut needed = vec![none; heard.len()];
    let need = |list: &mut [bool], at: usize| !std::mem::replace(&mut list[at], true);
    let value = |values: &[Value], at: usize| match values[at] {
        Value::Same(other, _) => Some(other),
        Value::Known(_) => None,
    };
    for (needed, values) in needed.iter_mut().zip(values) {
        for (at, _) in leaves(parts, values).into_iter().chain(blamed(parts, values)) {
            if let Some(at) = value(values, at) {
                need(&mut needed.value, at);
            }
        }
    }
    loop {
        let mut more = false;
        for (at, part) in parts.iter().enumerate() {
            if !needed.iter().any(|needed| needed.value[at]) {
                continue;
            }
            // What is asked for at one thing that is heard is noted at all others.
            for needed in &mut needed {
                more |= match part {
                    Part::Previous(a) => need(&mut needed.asked, *a),
                    _ => need(&mut needed.notes, at),
                };
            }
        }
        for ((needed, values), what) in needed.iter_mut().zip(values).zip(heard) {
            for (at, part) in parts.iter().enumerate() {
                if needed.asked[at]
                    && let Some(other) = value(values, at)
                {
                    more |= need(&mut needed.value, other);
                }
                let noted = needed.notes[at] && has_past(part) && notes(part, *what, values);
                if needed.value[at] || noted {
                    let of = part.made_of_now().filter(|of| asks(part, *of, values));
                    for other in of.filter_map(|other| value(values, other)) {
                        more |= need(&mut needed.value, other);
                    }
                }
            }
        }
        if !more {
            return needed;
        }
    }
}

/// Parts that are asked for to say which one is to blame, if the last one does not hold.
fn blamed(parts: &[Part], values: &[Value]) -> Vec<(usize, bool)> {
    let (mut left, mut asked) = (vec![parts.len() - 1], Vec::new());
    while let Some(at) = left.pop() {
        if values[at] == Value::Known(true) {
            continue;
        }
        match parts[at] {
            Part::And(a, b) => left.extend([a, b]),
            Part::Implies(_, b) => {
                asked.push((at, true));
                left.push(b);
            }
            _ => asked.push((at, true)),
        }
    }
    asked
}
