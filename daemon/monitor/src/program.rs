//! Formulas without names.

use genom_description::model::ServiceIx;

use crate::happening::Happening;
use crate::past::Bounds;

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

    /// Whether its value depends on what was before.
    pub(crate) fn has_memory(&self) -> bool {
        matches!(self, Self::Runs(_) | Self::Previous(_)) || self.bounds().is_some()
    }

    pub(crate) fn bounds(&self) -> Option<Bounds> {
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
        self.parts.iter().filter_map(Part::bounds).any(|bounds| bounds != Bounds::EVER)
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
