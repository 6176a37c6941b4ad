//! What of a formula depends on more than what happens.
//!
//! By what happens alone, many parts hold or do not: `codel a is called` does, `a -> b` holds where
//! nothing but something else happens, `once[0, 1s] a` holds where `a` does. So for each of what is
//! heard there are steps of their own, for the parts whose values are to be looked up or noted then,
//! and for no others: nobody asks for the values of all of them, and not all that happens is asked
//! for later.

use crate::happening::Happening;
use crate::program::{Part, Program};

/// One step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The part whose value it finds.
    pub(crate) part: u8,
    pub(crate) what: What,
}

/// How a value is found. Parts are given by number, and so are what services and dates are noted in.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// The service of this part starts.
    Starts,
    /// It ends.
    Ends,
    Runs,
    Not(u8),
    And(u8, u8),
    Or(u8, u8),
    Implies(u8, u8),
    Previous(u8),
    Once(u8, u8),
    Historically(u8, u8),
    Since(u8, u8, u8),
}

/// What one thing that is heard does to a formula.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heard {
    pub(crate) steps: Vec<Step>,
    /// The parts that hold by that alone, as bits.
    pub(crate) holds: u64,
}

/// For each of what a program hears: what it does.
pub(crate) fn steps(program: &Program, heard: &[Happening]) -> Vec<Heard> {
    let known: Vec<Vec<Option<bool>>> = heard.iter().map(|what| known(program, *what)).collect();
    let needed = needed(program, heard, &known);
    let one = |((what, known), needed): ((&Happening, &Vec<Option<bool>>), &Vec<bool>)| {
        let mut all = Heard::default();
        let mut pasts = 0;
        for (at, part) in program.parts().iter().enumerate() {
            let number = small(at);
            let past = pasts;
            pasts += u8::from(has_past(part));
            all.holds |= u64::from(known[at] == Some(true)) << at;
            let asked = needed[at] && known[at].is_none();
            let notes = needed[program.parts().len() + at] && notes(part, *what, known);
            if asked || notes {
                all.steps.extend(step(part, *what, past).map(|what| Step { part: number, what }));
            }
        }
        all
    };
    heard.iter().zip(&known).zip(&needed).map(one).collect()
}

/// Whether dates are noted for it.
pub(crate) fn has_past(part: &Part) -> bool {
    matches!(part, Part::Once(..) | Part::Historically(..) | Part::Since(..))
}

fn small(at: usize) -> u8 {
    u8::try_from(at).unwrap_or(u8::MAX)
}

fn step(part: &Part, what: Happening, past: u8) -> Option<What> {
    Some(match *part {
        Part::Constant(_) | Part::Happens(_) => return None,
        Part::Runs(service) if what == Happening::Start(service) => What::Starts,
        Part::Runs(service) if what == Happening::End(service) => What::Ends,
        Part::Runs(_) => What::Runs,
        Part::Not(a) => What::Not(small(a)),
        Part::And(a, b) => What::And(small(a), small(b)),
        Part::Or(a, b) => What::Or(small(a), small(b)),
        Part::Implies(a, b) => What::Implies(small(a), small(b)),
        Part::Previous(a) => What::Previous(small(a)),
        Part::Once(_, a) => What::Once(past, small(a)),
        Part::Historically(_, a) => What::Historically(past, small(a)),
        Part::Since(_, a, b) => What::Since(past, small(a), small(b)),
    })
}

/// The value of each part, where that follows from what happens.
fn known(program: &Program, what: Happening) -> Vec<Option<bool>> {
    let mut known: Vec<Option<bool>> = Vec::new();
    for part in program.parts() {
        let value = match part {
            Part::Constant(value) => Some(*value),
            Part::Happens(all) => Some(all.contains(&what)),
            Part::Runs(service) => (what == Happening::Start(*service)).then_some(true),
            Part::Not(a) => known[*a].map(|a| !a),
            Part::And(a, b) => either(known[*a], known[*b], false),
            Part::Or(a, b) => either(known[*a], known[*b], true),
            Part::Implies(a, b) => either(known[*a].map(|a| !a), known[*b], true),
            Part::Previous(_) => None,
            // Now is within bounds that begin with 0.
            Part::Once(bounds, a) => known[*a].filter(|a| *a && bounds.least == 0),
            Part::Historically(bounds, a) => known[*a].filter(|a| !*a && bounds.least == 0),
            Part::Since(bounds, a, b) => match (known[*a], known[*b]) {
                (_, Some(true)) if bounds.least == 0 => Some(true),
                (Some(false), Some(false)) => Some(false),
                _ => None,
            },
        };
        known.push(value);
    }
    known
}

/// The value of two parts together, of which each decides by being `decides`.
fn either(a: Option<bool>, b: Option<bool>, decides: bool) -> Option<bool> {
    match (a, b) {
        (Some(a), _) if a == decides => Some(decides),
        (_, Some(b)) if b == decides => Some(decides),
        (Some(_), Some(_)) => Some(!decides),
        _ => None,
    }
}

/// Whether what happens changes what is noted for a part.
fn notes(part: &Part, what: Happening, known: &[Option<bool>]) -> bool {
    match part {
        Part::Runs(service) => {
            what == Happening::Start(*service) || what == Happening::End(*service)
        }
        Part::Once(_, a) => known[*a] != Some(false),
        Part::Historically(_, a) => known[*a] != Some(true),
        Part::Since(_, a, b) => known[*a] != Some(true) || known[*b] != Some(false),
        _ => false,
    }
}

/// For each of what is heard, the parts whose values are needed at it, then those whose notes are
/// needed at any time.
fn needed(program: &Program, heard: &[Happening], known: &[Vec<Option<bool>>]) -> Vec<Vec<bool>> {
    let parts = program.parts();
    let mut needed = vec![vec![false; 2 * parts.len()]; heard.len()];
    for (needed, known) in needed.iter_mut().zip(known) {
        verdict(parts, known, parts.len() - 1, needed);
    }
    loop {
        let mut more = false;
        let mut need = |needed: &mut [bool], at: usize| {
            more |= !std::mem::replace(&mut needed[at], true);
        };
        // What is asked for at one thing that is heard is noted at all others.
        for (at, part) in parts.iter().enumerate() {
            let asked = (0..heard.len()).any(|l| needed[l][at] && known[l][at].is_none());
            if !asked {
                continue;
            }
            for needed in &mut needed {
                match part {
                    Part::Previous(a) => need(needed, *a),
                    _ => need(needed, parts.len() + at),
                }
            }
        }
        for ((needed, known), what) in needed.iter_mut().zip(known).zip(heard) {
            for (at, part) in parts.iter().enumerate() {
                let asked = needed[at] && known[at].is_none();
                let noted = needed[parts.len() + at] && notes(part, *what, known);
                if asked || noted && has_past(part) {
                    for other in part.made_of_now() {
                        need(needed, other);
                    }
                }
            }
        }
        if !more {
            return needed;
        }
    }
}

/// Needed for the verdict, and to say which part is to blame.
fn verdict(parts: &[Part], known: &[Option<bool>], at: usize, needed: &mut [bool]) {
    if known[at] == Some(true) {
        return;
    }
    needed[at] = true;
    match parts[at] {
        Part::Implies(_, b) => verdict(parts, known, b, needed),
        Part::And(a, b) => [a, b].into_iter().for_each(|at| verdict(parts, known, at, needed)),
        _ => {}
    }
}
