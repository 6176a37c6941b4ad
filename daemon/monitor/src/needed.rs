//! What of a formula is asked for where something happens, and what is noted for later.

use crate::literals::Literals;
use crate::program::{Part, Program};
use crate::value::{Value, both_of};

/// Parts, as bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Needed {
    /// For each of what is heard, those whose values are asked for then.
    pub(crate) values: Vec<u64>,
    /// Those with memory that are asked for at any of what is heard: at all of it is noted what
    /// their values depend on.
    pub(crate) noted: u64,
}

/// What is needed, with the value of each part at each of what is heard.
pub(crate) fn needed(program: &Program, values: &[Vec<Value>]) -> Needed {
    let parts = program.parts();
    let last = parts.len() - 1;
    let asked =
        |values: &Vec<Value>| mask(parts, values, (values[last], true)) | blamed(parts, values);
    let mut needed = Needed { values: values.iter().map(asked).collect(), noted: 0 };
    loop {
        let before = needed.clone();
        for (at, part) in parts.iter().enumerate().rev() {
            let own = 1 << at;
            if part.has_memory() && needed.values.iter().any(|values| values & own != 0) {
                needed.noted |= own;
            }
            for (needs, values) in needed.values.iter_mut().zip(values) {
                let depends = if part.has_memory() { needed.noted } else { *needs };
                if depends & own != 0 {
                    *needs |= operands(parts, values, part);
                }
            }
        }
        if needed == before {
            return needed;
        }
    }
}

/// The bits on which it depends whether a value is the wanted one.
fn mask(parts: &[Part], values: &[Value], wanted: (Value, bool)) -> u64 {
    Literals::of(parts, values, [wanted]).map_or(0, |all| all.mask)
}

/// The bits on which the value of a part depends, or what is noted for it.
fn operands(parts: &[Part], values: &[Value], part: &Part) -> u64 {
    if let Some((a, b, _)) = both_of(part, values) {
        return Literals::of(parts, values, [(a, true), (b, true)]).map_or(0, |all| all.mask);
    }
    if let Part::Previous(a) = *part {
        return mask(parts, values, (values[a], true));
    }
    let Some((noted, bounds)) = part.noted() else { return 0 };
    let (stays, holds) = noted.values(values, bounds);
    mask(parts, values, (stays, false)) | mask(parts, values, (holds, true))
}

/// Bits that say which part is to blame, if the last one does not hold.
fn blamed(parts: &[Part], values: &[Value]) -> u64 {
    let (mut left, mut asked) = (vec![parts.len() - 1], 0);
    while let Some(at) = left.pop() {
        match parts[at] {
            _ if values[at] == Value::Known(true) => {}
            Part::And(a, b) => {
                asked |= remembered(parts, values, values[a]);
                left.extend([a, b]);
            }
            Part::Implies(_, b) => left.push(b),
            _ => {}
        }
    }
    asked
}

/// The parts with memory that a value is made of.
fn remembered(parts: &[Part], values: &[Value], value: Value) -> u64 {
    let Value::Same(at, _) = value else { return 0 };
    match both_of(&parts[at], values) {
        Some((a, b, _)) => remembered(parts, values, a) | remembered(parts, values, b),
        None => 1 << at,
    }
}
