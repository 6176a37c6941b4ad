//! What the values of parts are where something happens, as far as that is known beforehand: those
//! that follow from what happens, and those that are always the same as another one's.

use crate::happening::Happening;
use crate::past::Bounds;
use crate::program::{Part, Program};

/// The value of a part where something happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Value {
    /// It follows from what happens.
    Known(bool),
    /// That of a part, or with `true` its contrary; its own if that part is itself.
    Same(usize, bool),
}

impl Value {
    fn not(self) -> Self {
        self.unless(true)
    }

    /// The contrary if `negated`.
    fn unless(self, negated: bool) -> Self {
        match self {
            Self::Known(holds) => Self::Known(holds != negated),
            Self::Same(part, contrary) => Self::Same(part, contrary != negated),
        }
    }
}

/// For each of what a program hears, the value of each part.
pub(crate) fn values(program: &Program, heard: &[Happening]) -> Vec<Vec<Value>> {
    let parts = program.parts();
    let mut values: Vec<Vec<Value>> = vec![Vec::new(); heard.len()];
    for (at, part) in parts.iter().enumerate() {
        let twin = (0..at).find_map(|other| {
            let negated = remembers_as(part, &parts[other], &values)?;
            Some((other, negated))
        });
        // Whatever happens.
        let always = |values: &[Vec<Value>], of: usize, holds: bool| {
            values.iter().all(|values| values[of] == Value::Known(holds))
        };
        let fixed = match *part {
            Part::Previous(a) | Part::Once(_, a) | Part::Since(_, _, a)
                if always(&values, a, false) =>
            {
                Some(Value::Known(false))
            }
            Part::Historically(_, a) if always(&values, a, true) => Some(Value::Known(true)),
            _ => None,
        };
        for (values, what) in values.iter_mut().zip(heard) {
            let value = match (twin, fixed) {
                (Some((other, negated)), _) => values[other].unless(negated),
                (None, Some(fixed)) => fixed,
                (None, None) => value(parts, at, *what, values),
            };
            values.push(value);
        }
    }
    values
}

fn value(parts: &[Part], at: usize, what: Happening, values: &[Value]) -> Value {
    let own = Value::Same(at, false);
    match &parts[at] {
        Part::Constant(holds) => Value::Known(*holds),
        Part::Happens(all) => Value::Known(all.contains(&what)),
        Part::Runs(service) if what == Happening::Start(*service) => Value::Known(true),
        Part::Not(a) => values[*a].not(),
        part @ (Part::And(..) | Part::Or(..) | Part::Implies(..)) => {
            let Some((a, b, negated)) = both_of(part, values) else { return own };
            match both(a, b) {
                Some(value) => value.unless(negated),
                None => twin(parts, at, values).unwrap_or(own),
            }
        }
        // Now is within bounds that begin with 0.
        Part::Once(bounds, a) if bounds.least == 0 && values[*a] == Value::Known(true) => {
            Value::Known(true)
        }
        Part::Historically(bounds, a) if bounds.least == 0 && values[*a] == Value::Known(false) => {
            Value::Known(false)
        }
        Part::Since(bounds, a, b) => match (values[*a], values[*b]) {
            (_, Value::Known(true)) if bounds.least == 0 => Value::Known(true),
            (Value::Known(false), Value::Known(false)) => Value::Known(false),
            _ => own,
        },
        Part::Runs(_) | Part::Previous(_) | Part::Once(..) | Part::Historically(..) => own,
    }
}

/// The two values of which a part says that both hold, or with `true` that not both do.
pub(crate) fn both_of(part: &Part, values: &[Value]) -> Option<(Value, Value, bool)> {
    match *part {
        Part::And(a, b) => Some((values[a], values[b], false)),
        Part::Or(a, b) => Some((values[a].not(), values[b].not(), true)),
        Part::Implies(a, b) => Some((values[a], values[b].not(), true)),
        _ => None,
    }
}

fn both(a: Value, b: Value) -> Option<Value> {
    match (a, b) {
        (Value::Known(false), _) | (_, Value::Known(false)) => Some(Value::Known(false)),
        (Value::Known(true), other) | (other, Value::Known(true)) => Some(other),
        _ if a == b => Some(a),
        _ if a == b.not() => Some(Value::Known(false)),
        _ => None,
    }
}

/// The value of a part before this one that says the same of the same two values.
fn twin(parts: &[Part], at: usize, values: &[Value]) -> Option<Value> {
    let (a, b, negated) = both_of(parts.get(at)?, values)?;
    (0..at).filter(|other| values[*other] == Value::Same(*other, false)).find_map(|other| {
        let (c, d, contrary) = both_of(&parts[other], values)?;
        let same = (a, b) == (c, d) || (a, b) == (d, c);
        same.then_some(Value::Same(other, negated != contrary))
    })
}

/// Whether two parts remember the same at all that is heard, so that their values are the same; or
/// with `true` contraries.
fn remembers_as(part: &Part, other: &Part, values: &[Vec<Value>]) -> Option<bool> {
    let same = |a: usize, b: usize| values.iter().all(|values| values[a] == values[b]);
    match (part, other) {
        (Part::Runs(a), Part::Runs(b)) => (a == b).then_some(false),
        // At the first event neither it nor that of a contrary holds.
        (Part::Previous(a), Part::Previous(b)) => same(*a, *b).then_some(false),
        _ => {
            let ((one, bounds), (two, others)) = (part.noted()?, other.noted()?);
            let alike =
                |values: &Vec<Value>| one.values(values, bounds) == two.values(values, bounds);
            let same = bounds == others && values.iter().all(alike);
            same.then_some(one.negated != two.negated)
        }
    }
}

/// What a part with bounds notes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noted {
    /// What is noted before stays if this part holds; always if `None`.
    stays: Option<usize>,
    /// It is noted where this part holds, or with `negated` does not.
    holds: usize,
    /// The part holds if nothing is noted between its bounds.
    negated: bool,
}

impl Noted {
    /// Whether what is noted stays, and whether it is noted. Where the last date is kept, and this is
    /// it, what was before says no more.
    pub(crate) fn values(self, values: &[Value], bounds: Bounds) -> (Value, Value) {
        let holds = values[self.holds].unless(self.negated);
        let only = bounds.least == 0 && holds == Value::Known(true);
        let stays = self.stays.filter(|_| !only);
        (stays.map_or(Value::Known(true), |stays| values[stays]), holds)
    }
}

impl Part {
    /// What it notes, and its bounds, if it has some.
    pub(crate) fn noted(&self) -> Option<(Noted, Bounds)> {
        let noted = |stays, holds, negated| Noted { stays, holds, negated };
        match *self {
            Self::Once(bounds, a) => Some((noted(None, a, false), bounds)),
            Self::Historically(bounds, a) => Some((noted(None, a, true), bounds)),
            Self::Since(bounds, a, b) => Some((noted(Some(a), b, false), bounds)),
            _ => None,
        }
    }
}
