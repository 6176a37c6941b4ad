//! What formulas are made of.

/// A formula, or a part of one, about facts `A`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Term<A> {
    /// True or false.
    Const(bool),
    /// A fact.
    Atom(A),
    /// It is not so.
    Not(Box<Self>),
    /// Two of them.
    Two(Join, Box<Self>, Box<Self>),
    /// From now on.
    Always(Box<Self>),
    /// Now or later.
    Eventually(Box<Self>),
    /// The first one until the second one, which comes.
    Until(Box<Self>, Box<Self>),
    /// Now or before.
    Once(Box<Self>),
    /// Until now.
    Historically(Box<Self>),
    /// The first one since the second one, which was.
    Since(Box<Self>, Box<Self>),
    /// In the state before.
    Previous(Box<Self>),
}

/// What joins two formulas without time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Both.
    And,
    /// One of them, or both.
    Or,
    /// The second one if the first one.
    Implies,
    /// Both or none.
    Equal,
}

impl Join {
    /// The truth of both, by that of each.
    #[must_use]
    pub fn of(self, a: bool, b: bool) -> bool {
        match self {
            Self::And => a && b,
            Self::Or => a || b,
            Self::Implies => !a || b,
            Self::Equal => a == b,
        }
    }
}

impl<A> Term<A> {
    /// The parts of a formula.
    #[must_use]
    pub fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Const(_) | Self::Atom(_) => Vec::new(),
            Self::Not(a)
            | Self::Always(a)
            | Self::Eventually(a)
            | Self::Once(a)
            | Self::Historically(a)
            | Self::Previous(a) => vec![a],
            Self::Two(_, a, b) | Self::Until(a, b) | Self::Since(a, b) => vec![a, b],
        }
    }

    /// Whether it, or a part of it, is wanted.
    pub fn any(&self, wanted: &dyn Fn(&Self) -> bool) -> bool {
        wanted(self) || self.parts().into_iter().any(|part| part.any(wanted))
    }

    /// Whether it is about what comes.
    #[must_use]
    pub fn is_future(&self) -> bool {
        matches!(self, Self::Always(_) | Self::Eventually(_) | Self::Until(..))
    }

    /// Whether it is about what was.
    #[must_use]
    pub fn is_past(&self) -> bool {
        matches!(self, Self::Once(_) | Self::Historically(_) | Self::Since(..) | Self::Previous(_))
    }

    /// Whether it is about one state, with all its parts.
    #[must_use]
    pub fn is_now(&self) -> bool {
        !self.any(&|term| term.is_future() || term.is_past())
    }

    /// Whether it holds in a state in which these facts do, if it is about one.
    pub fn holds(&self, fact: &dyn Fn(&A) -> bool) -> bool {
        match self {
            Self::Const(value) => *value,
            Self::Atom(atom) => fact(atom),
            Self::Not(a) => !a.holds(fact),
            Self::Two(join, a, b) => join.of(a.holds(fact), b.holds(fact)),
            _ => false,
        }
    }
}
