//! Formulas, compiled: one bit for each part, computed from the parts before it and from what held
//! at the event before (Havelund and Rosu, Synthesizing Monitors for Safety Properties, 2002).

use genom_description::model::ServiceIx;

use crate::happening::Happening;
use crate::past::{Bounds, Past};

/// Limit on the parts of a formula.
pub const MOST_PARTS: usize = 64;

/// A formula without names: parts in such an order that each comes after those that it is made of.
/// The last one has to hold at each event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    parts: Vec<Part>,
    texts: Vec<String>,
}

/// A part of a formula; others are given by index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// `true` or `false`.
    Constant(bool),
    /// One of these happens.
    Happens(Vec<Happening>),
    /// A service has started and not ended.
    Runs(ServiceIx),
    /// Not.
    Not(usize),
    /// Both.
    And(usize, usize),
    /// One or both.
    Or(usize, usize),
    /// The second where the first holds.
    Implies(usize, usize),
    /// At the event before.
    Previous(usize),
    /// Between the bounds before now.
    Once(Bounds, usize),
    /// Always between the bounds before now.
    Historically(Bounds, usize),
    /// The second held between the bounds before now, and the first at all events since.
    Since(Bounds, usize, usize),
}

/// Why parts are no program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoProgram {
    /// Too many, none, or one that refers to a later one.
    #[error("a formula has from 1 to {MOST_PARTS} parts, each after those that it is made of")]
    Parts,
    /// Bounds that would need too many dates.
    #[error(
        "`{0}` would have to remember too many dates: the second bound is to be at most 31 times \
         the difference of the two, or one of them 0 or inf"
    )]
    Narrow(String),
}

impl Part {
    fn made_of(&self) -> [Option<usize>; 2] {
        match *self {
            Self::Constant(_) | Self::Happens(_) | Self::Runs(_) => [None; 2],
            Self::Not(a) | Self::Previous(a) | Self::Once(_, a) | Self::Historically(_, a) => {
                [Some(a), None]
            }
            Self::And(a, b) | Self::Or(a, b) | Self::Implies(a, b) | Self::Since(_, a, b) => {
                [Some(a), Some(b)]
            }
        }
    }

    fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Once(bounds, _) | Self::Historically(bounds, _) | Self::Since(bounds, ..) => {
                Some(*bounds)
            }
            _ => None,
        }
    }
}

impl Program {
    /// A program of these parts, each with its text.
    ///
    /// # Errors
    /// They are none.
    pub fn new(parts: Vec<(Part, String)>) -> Result<Self, NoProgram> {
        let (parts, texts): (Vec<Part>, Vec<String>) = parts.into_iter().unzip();
        let in_order = |(at, part): (usize, &Part)| {
            part.made_of().into_iter().flatten().all(|other| other < at)
        };
        if parts.is_empty() || parts.len() > MOST_PARTS || !parts.iter().enumerate().all(in_order) {
            return Err(NoProgram::Parts);
        }
        let narrow = |part: &Part| part.bounds().is_some_and(|bounds| bounds.dates().is_none());
        if let Some(at) = parts.iter().position(narrow) {
            return Err(NoProgram::Narrow(texts[at].clone()));
        }
        Ok(Self { parts, texts })
    }

    /// The parts.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The text of a part.
    #[must_use]
    pub fn text(&self, part: usize) -> &str {
        self.texts.get(part).map_or("", String::as_str)
    }

    /// Whether it asks how long ago something was.
    #[must_use]
    pub fn has_bounds(&self) -> bool {
        let any = Bounds { least: 0, most: u64::MAX };
        self.parts.iter().filter_map(Part::bounds).any(|bounds| bounds != any)
    }

    /// All that it has to hear of.
    #[must_use]
    pub fn hears(&self) -> Vec<Happening> {
        let mut all = Vec::new();
        for part in &self.parts {
            let heard = match part {
                Part::Happens(heard) => heard.clone(),
                Part::Runs(service) => {
                    vec![Happening::Start(*service), Happening::End(*service)]
                }
                _ => continue,
            };
            heard.into_iter().for_each(|one| {
                if !all.contains(&one) {
                    all.push(one);
                }
            });
        }
        all
    }
}

/// A formula at one moment.
#[derive(Clone, Debug)]
pub struct Judge {
    parts: Box<[Compiled]>,
    /// For each of what it hears, the parts that hold by that alone.
    truths: Box<[u64]>,
    /// For each of what it hears, the services that start or end by it, as parts.
    moves: Box<[(u64, u64)]>,
    /// How many times each service of a part runs.
    running: Box<[u32]>,
    pasts: Box<[Past]>,
    /// What held at the event before.
    before: u64,
}

/// A part, small.
#[derive(Clone, Copy, Debug)]
enum Compiled {
    Constant(bool),
    /// By what happens.
    Given,
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

impl Judge {
    /// At the beginning: nothing has happened.
    #[must_use]
    pub fn new(program: &Program) -> Self {
        let small = |at: usize| u8::try_from(at).unwrap_or(u8::MAX);
        let mut pasts = Vec::new();
        let mut past = |bounds: Bounds| {
            pasts.push(Past::new(bounds));
            small(pasts.len() - 1)
        };
        let compiled = |part: &Part| match *part {
            Part::Constant(value) => Compiled::Constant(value),
            Part::Happens(_) => Compiled::Given,
            Part::Runs(_) => Compiled::Runs,
            Part::Not(a) => Compiled::Not(small(a)),
            Part::And(a, b) => Compiled::And(small(a), small(b)),
            Part::Or(a, b) => Compiled::Or(small(a), small(b)),
            Part::Implies(a, b) => Compiled::Implies(small(a), small(b)),
            Part::Previous(a) => Compiled::Previous(small(a)),
            Part::Once(bounds, a) => Compiled::Once(past(bounds), small(a)),
            Part::Historically(bounds, a) => Compiled::Historically(past(bounds), small(a)),
            Part::Since(bounds, a, b) => Compiled::Since(past(bounds), small(a), small(b)),
        };
        let parts = program.parts.iter().map(compiled).collect();
        let heard = program.hears();
        let mask = |so: &dyn Fn(&Part) -> bool| {
            let all = program.parts.iter().enumerate().filter(|(_, part)| so(part));
            all.fold(0, |mask, (at, _)| mask | 1 << at)
        };
        let truth = |what: &Happening| {
            mask(&|part| matches!(part, Part::Happens(all) if all.contains(what)))
        };
        let moves = |what: &Happening| {
            let of = |service: ServiceIx| mask(&|part| *part == Part::Runs(service));
            match *what {
                Happening::Start(service) => (of(service), 0),
                Happening::End(service) => (0, of(service)),
                _ => (0, 0),
            }
        };
        Self {
            parts,
            truths: heard.iter().map(truth).collect(),
            moves: heard.iter().map(moves).collect(),
            running: vec![0; program.parts.len()].into_boxed_slice(),
            pasts: pasts.into_boxed_slice(),
            before: 0,
        }
    }

    /// What is heard under this number happens at this date. Returns the part because of which the
    /// formula does not hold.
    #[inline]
    pub fn hear(&mut self, letter: usize, now: u64) -> Option<usize> {
        let given = self.truths.get(letter).copied().unwrap_or_default();
        let (starts, ends) = self.moves.get(letter).copied().unwrap_or_default();
        let mut held = 0u64;
        let bit = |bits: u64, at: u8| bits >> at & 1 == 1;
        for (at, part) in self.parts.iter().enumerate() {
            let holds = match *part {
                Compiled::Constant(value) => value,
                Compiled::Given => given >> at & 1 == 1,
                Compiled::Runs => {
                    let running = &mut self.running[at];
                    *running += u32::from(starts >> at & 1 == 1);
                    *running = running.saturating_sub(u32::from(ends >> at & 1 == 1));
                    *running > 0
                }
                Compiled::Not(a) => !bit(held, a),
                Compiled::And(a, b) => bit(held, a) && bit(held, b),
                Compiled::Or(a, b) => bit(held, a) || bit(held, b),
                Compiled::Implies(a, b) => !bit(held, a) || bit(held, b),
                Compiled::Previous(a) => bit(self.before, a),
                Compiled::Once(past, a) => {
                    self.pasts[usize::from(past)].goes_on(true, bit(held, a), now)
                }
                Compiled::Historically(past, a) => {
                    !self.pasts[usize::from(past)].goes_on(true, !bit(held, a), now)
                }
                Compiled::Since(past, a, b) => {
                    self.pasts[usize::from(past)].goes_on(bit(held, a), bit(held, b), now)
                }
            };
            held |= u64::from(holds) << at;
        }
        self.before = held;
        let last = self.parts.len() - 1;
        (held >> last & 1 == 0).then(|| self.blamed(last))
    }

    /// The smallest part because of which this one does not hold, as far as one is to blame.
    #[cold]
    fn blamed(&self, mut at: usize) -> usize {
        let holds = |at: u8| self.before >> at & 1 == 1;
        loop {
            at = match self.parts[at] {
                Compiled::Implies(_, b) => usize::from(b),
                Compiled::And(a, b) => usize::from(if holds(a) { b } else { a }),
                _ => return at,
            };
        }
    }

    /// Where it is, apart from dates: two with the same answer to this will judge alike if the
    /// formula has no bounds.
    #[must_use]
    pub fn place(&self) -> (u64, Vec<bool>, Vec<u32>) {
        let any = self.pasts.iter().map(Past::any).collect();
        (self.before, any, self.running.to_vec())
    }
}
