//! Formulas, taken apart.

use std::fmt;
use std::time::Duration;

use super::super::short::Short;
use super::word::Atom;

/// A formula. Names are not looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Formula {
    /// `true` or `false`.
    Constant(bool),
    /// Something happens, or an activity runs.
    Atom(Atom),
    /// Not.
    Not(Box<Formula>),
    /// Both.
    And(Box<Formula>, Box<Formula>),
    /// One or both.
    Or(Box<Formula>, Box<Formula>),
    /// The second where the first holds.
    Implies(Box<Formula>, Box<Formula>),
    /// At the event before; not at the first.
    Previous(Box<Formula>),
    /// At this event or one before, that long ago.
    Once(Within, Box<Formula>),
    /// At all events until this one, that long ago.
    Historically(Within, Box<Formula>),
    /// The second held, that long ago, and the first at all events after that.
    Since(Within, Box<Formula>, Box<Formula>),
}

/// How long ago something was: from a least to a greatest time, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Within {
    /// The least time.
    pub least: Duration,
    /// The greatest; `None` for any.
    pub most: Option<Duration>,
}

impl Within {
    /// However long ago.
    pub const EVER: Self = Self { least: Duration::ZERO, most: None };
}

impl Formula {
    /// How strongly it binds, to be written within another one.
    fn rank(&self) -> u8 {
        match self {
            Self::Implies(..) => 0,
            Self::Or(..) => 1,
            Self::And(..) => 2,
            Self::Since(..) => 3,
            _ => 4,
        }
    }

    fn within(&self, f: &mut fmt::Formatter<'_>, rank: u8) -> fmt::Result {
        if self.rank() < rank { write!(f, "({self})") } else { write!(f, "{self}") }
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let two = |f: &mut fmt::Formatter<'_>, a: &Self, word: &str, b: &Self, rank: u8| {
            a.within(f, rank + u8::from(rank == 0))?;
            write!(f, " {word} ")?;
            b.within(f, rank + u8::from(rank > 0))
        };
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Atom(atom) => atom.fmt(f),
            Self::Not(of) => {
                f.write_str("not ")?;
                of.within(f, 4)
            }
            Self::Implies(a, b) => two(f, a, "->", b, 0),
            Self::Or(a, b) => two(f, a, "or", b, 1),
            Self::And(a, b) => two(f, a, "and", b, 2),
            Self::Since(within, a, b) => two(f, a, &format!("since{within}"), b, 3),
            Self::Previous(of) => {
                f.write_str("previous ")?;
                of.within(f, 4)
            }
            Self::Once(within, of) => {
                write!(f, "once{within} ")?;
                of.within(f, 4)
            }
            Self::Historically(within, of) => {
                write!(f, "historically{within} ")?;
                of.within(f, 4)
            }
        }
    }
}

impl fmt::Display for Within {
    /// `[0, 2 s]`; nothing for any time.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::EVER {
            return Ok(());
        }
        match self.least {
            Duration::ZERO => f.write_str("[0, ")?,
            least => write!(f, "[{}, ", Short(least))?,
        }
        match self.most {
            None => f.write_str("inf]"),
            Some(most) => write!(f, "{}]", Short(most)),
        }
    }
}
