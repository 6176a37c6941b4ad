//! Declarations, statements and expressions once they are read.

use std::rc::Rc;

/// A type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    /// With its range.
    Int(i32, i32),
    Bool,
    Array(Rc<Self>, usize),
    Record(Rc<Vec<(String, Self)>>),
    Clock,
    /// Urgent, and broadcast.
    Channel,
    Void,
}

impl Type {
    /// The least and the greatest number that it may be.
    pub(crate) fn range(&self) -> Option<(i32, i32)> {
        match self {
            Self::Int(least, most) => Some((*least, *most)),
            Self::Bool => Some((0, 1)),
            _ => None,
        }
    }

    /// Numbers that a value of it has.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::Int(..) | Self::Bool | Self::Clock => 1,
            Self::Array(of, count) => of.size() * count,
            Self::Record(fields) => fields.iter().map(|(_, of)| of.size()).sum(),
            Self::Channel | Self::Void => 0,
        }
    }

    /// The range of each of its numbers.
    pub(crate) fn ranges(&self) -> Vec<(i32, i32)> {
        match self {
            Self::Int(..) | Self::Bool => self.range().into_iter().collect(),
            Self::Array(of, count) => of.ranges().repeat(*count),
            Self::Record(fields) => fields.iter().flat_map(|(_, of)| of.ranges()).collect(),
            Self::Clock | Self::Channel | Self::Void => Vec::new(),
        }
    }
}

/// Where a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    Constant,
    Global,
    Local,
    Clock,
}

/// A variable, or a part of one.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) space: Space,
    pub(crate) base: usize,
    /// Indices, with the size of what they count and how much there is of that.
    pub(crate) indices: Vec<(Expr, usize, usize)>,
    pub(crate) of: Type,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    And,
    Or,
    Equal,
    Differ,
    Less,
    AtMost,
    AtLeast,
    Greater,
    Plus,
    Minus,
    Times,
}

#[derive(Clone, Debug)]
pub(crate) enum Expr {
    Number(i32),
    Load(Place),
    Not(Box<Self>),
    Two(Operator, Box<Self>, Box<Self>),
    /// A number into a variable.
    Assign(Place, Box<Self>),
    /// All of a record.
    Copy(Place, Place),
    /// One more or less.
    Step(Place, i32),
    Call(usize, Vec<Self>),
    /// Of a query: nothing more can be done.
    Deadlock,
}

#[derive(Clone, Debug)]
pub(crate) enum Statement {
    Do(Expr),
    If(Expr, Box<Self>, Option<Box<Self>>),
    While(Expr, Box<Self>),
    /// What is done first, for how long, and after each time.
    For(Box<[Expr; 3]>, Box<Self>),
    Return(Option<Expr>),
    All(Vec<Self>),
}

#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) gives: Type,
    /// Ranges of its parameters.
    pub(crate) takes: Vec<(i32, i32)>,
    /// Numbers that its parameters and variables need.
    pub(crate) frame: usize,
    pub(crate) body: Statement,
    /// It changes what is not its own.
    pub(crate) changes: bool,
}

/// What an expression is about, in the order of what may stand where another one may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Int,
    /// Upper bounds of clocks.
    Invariant,
    /// Any closed bounds of clocks, all of which hold.
    Guard,
    /// Anything about clocks.
    Constraint,
    Clock,
    Record,
    Void,
}
