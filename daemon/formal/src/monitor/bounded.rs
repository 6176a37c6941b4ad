//! Formulas with bounds: what the same formula without them says.
//!
//! `once[a, b] p` holds only where `once p` does, `historically[a, b] p` wherever `historically p`
//! does. So where bounds only make a formula hold less often, what breaks it without them breaks it;
//! and where they only make it hold more often, what never breaks it without them never does.

use genom_runtime::{Bounds, Part, Program};

use super::fires::Fires;

const ANY: Bounds = Bounds { least: 0, most: u64::MAX };

/// How a formula without its bounds compares with the one that has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Without {
    /// It holds wherever the other one does.
    Weaker,
    /// The other one holds wherever it does.
    Stronger,
}

/// The formula without its bounds; `None` if neither follows from the other one.
pub(super) fn without(program: &Program) -> Option<(Without, Program)> {
    let parts = program.parts();
    let mut signs = vec![Signs::default(); parts.len()];
    signs.last_mut()?.plain = true;
    let (mut weaker, mut stronger) = (true, true);
    for (at, part) in parts.iter().enumerate().rev() {
        let own = signs[at];
        let mut made_of = |other: usize, sign: Signs| signs[other].add(sign);
        match *part {
            Part::Constant(_) | Part::Happens(_) | Part::Runs(_) => {}
            Part::Not(a) => made_of(a, own.turned()),
            Part::And(a, b) | Part::Or(a, b) | Part::Since(_, a, b) => {
                made_of(a, own);
                made_of(b, own);
            }
            Part::Implies(a, b) => {
                made_of(a, own.turned());
                made_of(b, own);
            }
            Part::Previous(a) | Part::Once(_, a) | Part::Historically(_, a) => made_of(a, own),
        }
        // Whether the bounds of this part make the whole hold less often, or more often.
        let (less, more) = match part {
            Part::Once(bounds, _) | Part::Since(bounds, ..) if *bounds != ANY => {
                (own.plain, own.negated)
            }
            Part::Historically(bounds, _) if *bounds != ANY => (own.negated, own.plain),
            _ => continue,
        };
        weaker &= !more;
        stronger &= !less;
    }
    let how = match (weaker, stronger) {
        (true, _) => Without::Weaker,
        (false, true) => Without::Stronger,
        (false, false) => return None,
    };
    let free = |(at, part): (usize, &Part)| {
        let part = match *part {
            Part::Once(_, a) => Part::Once(ANY, a),
            Part::Historically(_, a) => Part::Historically(ANY, a),
            Part::Since(_, a, b) => Part::Since(ANY, a, b),
            ref other => other.clone(),
        };
        (part, program.text(at).to_owned())
    };
    let parts = parts.iter().enumerate().map(free).collect();
    Some((how, Program::new(parts).ok()?))
}

/// Whether what was found of the formula without its bounds says the same of the one with them.
pub(super) fn decides(how: Without, found: &Fires) -> bool {
    !matches!(
        (found, how),
        (Fires::Never, Without::Weaker)
            | (Fires::Can { .. } | Fires::Always { .. }, Without::Stronger)
            | (Fires::Undecided(_), _)
    )
}

/// Whether a part of a formula is used as it is, negated, or both.
#[derive(Clone, Copy, Debug, Default)]
struct Signs {
    plain: bool,
    negated: bool,
}

impl Signs {
    fn turned(self) -> Self {
        Self { plain: self.negated, negated: self.plain }
    }

    fn add(&mut self, other: Self) {
        self.plain |= other.plain;
        self.negated |= other.negated;
    }
}
