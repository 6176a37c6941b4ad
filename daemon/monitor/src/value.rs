//! What the values of parts are where something happens, as far as that is known beforehand.

use crate::happening::Happening;
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
        match self {
            Self::Known(holds) => Self::Known(!holds),
            Self::Same(part, negated) => Self::Same(part, !negated),
        }
    }
}

/// For each of what a program hears, the value of each part.
pub(crate) fn values(program: &Program, heard: &[Happening]) -> Vec<Vec<Value>> {
    let mut values: Vec<Vec<Value>> = vec![Vec::new(); heard.len()];
    for (at, part) in program.parts().iter().enumerate() {
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
            let value = fixed.unwrap_or_else(|| value(part, at, *what, values));
            values.push(value);
        }
    }
    values
}

fn value(part: &Part, at: usize, what: Happening, values: &[Value]) -> Value {
    let own = Value::Same(at, false);
    match part {
        Part::Constant(holds) => Value::Known(*holds),
        Part::Happens(all) => Value::Known(all.contains(&what)),
        Part::Runs(service) if what == Happening::Start(*service) => Value::Known(true),
        Part::Not(a) => values[*a].not(),
        Part::And(a, b) => both(values[*a], values[*b], own),
        Part::Or(a, b) => either(values[*a], values[*b], own),
        Part::Implies(a, b) => either(values[*a].not(), values[*b], own),
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

fn both(a: Value, b: Value, own: Value) -> Value {
    match (a, b) {
        (Value::Known(false), _) | (_, Value::Known(false)) => Value::Known(false),
        (Value::Known(true), other) | (other, Value::Known(true)) => other,
        _ if a == b => a,
        _ if a == b.not() => Value::Known(false),
        _ => own,
    }
}

fn either(a: Value, b: Value, own: Value) -> Value {
    match (a, b) {
        (Value::Known(true), _) | (_, Value::Known(true)) => Value::Known(true),
        (Value::Known(false), other) | (other, Value::Known(false)) => other,
        _ if a == b => a,
        _ if a == b.not() => Value::Known(true),
        _ => own,
    }
}
