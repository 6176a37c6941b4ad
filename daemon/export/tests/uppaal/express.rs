//! Reads expressions, and checks them as libutap's type checker does.

use super::code::{Expr, Kind, Operator, Place, Space, Type};
use super::lex::Token;
use super::memory::{Machine, Values};
use super::names::{Name, Names};

/// Tokens, and what their names mean.
pub(crate) struct Reader<'n> {
    pub(crate) names: &'n mut Names,
    tokens: Vec<Token>,
    at: usize,
}

/// Operators from the weakest to the strongest.
const LEVELS: [&[(&str, Operator)]; 6] = [
    &[("||", Operator::Or)],
    &[("&&", Operator::And)],
    &[("==", Operator::Equal), ("!=", Operator::Differ)],
    &[
        ("<", Operator::Less),
        ("<=", Operator::AtMost),
        (">=", Operator::AtLeast),
        (">", Operator::Greater),
    ],
    &[("+", Operator::Plus), ("-", Operator::Minus)],
    &[("*", Operator::Times)],
];

impl<'n> Reader<'n> {
    pub(crate) fn new(text: &str, names: &'n mut Names) -> Self {
        Self { names, tokens: super::lex::tokens(text), at: 0 }
    }

    pub(crate) fn peek(&self) -> &Token {
        self.tokens.get(self.at).unwrap_or(&Token::End)
    }

    pub(crate) fn next(&mut self) -> Token {
        let token = self.peek().clone();
        self.at += 1;
        token
    }

    pub(crate) fn is_word(&self, word: &str) -> bool {
        matches!(self.peek(), Token::Word(found) if found == word)
    }

    /// The next token, if it is this one.
    pub(crate) fn takes(&mut self, token: &str) -> bool {
        let is_it = match self.peek() {
            Token::Word(found) => found == token,
            Token::Sign(found) => *found == token,
            Token::Number(_) | Token::End => false,
        };
        self.at += usize::from(is_it);
        is_it
    }

    pub(crate) fn expect(&mut self, token: &str) {
        let near = self.at.saturating_sub(8)..(self.at + 4).min(self.tokens.len());
        if !self.takes(token) {
            panic!("`{token}` is wanted, near {:?}", self.tokens.get(near));
        }
    }

    pub(crate) fn name(&mut self) -> String {
        match self.next() {
            Token::Word(word) => word,
            other => panic!("a name is wanted, and there is {other:?}"),
        }
    }

    /// Nothing is left.
    pub(crate) fn end(&self) {
        assert_eq!(self.peek(), &Token::End);
    }

    /// A number that is known before the model runs.
    pub(crate) fn constant(&mut self) -> i32 {
        let (expr, kind) = self.expr();
        assert_eq!(kind, Kind::Int);
        assert!(is_constant(&expr), "{expr:?} is no constant");
        Machine::new(&self.names.fixed.clone(), &mut Values::default()).value(&expr)
    }

    /// An expression without side effect.
    pub(crate) fn pure(&mut self, most: Kind) -> Expr {
        let (expr, kind) = self.implication();
        assert!(!self.changes(&expr, true), "{expr:?} changes something");
        assert!(kind <= most, "{expr:?} is {kind:?}, and {most:?} may be here");
        expr
    }

    /// `imply` is the weakest operator.
    fn implication(&mut self) -> (Expr, Kind) {
        let (a, kind) = self.expr();
        if !self.takes("imply") {
            return (a, kind);
        }
        let not = if kind == Kind::Int { Kind::Int } else { Kind::Constraint };
        let (b, other) = self.implication();
        (two(Operator::Or, Expr::Not(Box::new(a)), b), either(not, other))
    }

    /// An assignment, or an expression that something can be done with.
    pub(crate) fn expr(&mut self) -> (Expr, Kind) {
        let (expr, kind) = self.level(0);
        if !self.takes("=") {
            return (expr, kind);
        }
        let Expr::Load(to) = expr else { panic!("{expr:?} is assigned") };
        let (from, of) = self.expr();
        if kind == Kind::Record {
            let Expr::Load(from) = from else { panic!("{from:?} is no record") };
            assert_eq!((to.space, &to.of), (from.space, &from.of), "records of two types");
            return (Expr::Copy(to, from), Kind::Record);
        }
        assert_eq!(of, Kind::Int, "{to:?} is assigned");
        assert!(!(self.names.in_function && kind == Kind::Clock), "a function sets a clock");
        (Expr::Assign(to, Box::new(from)), kind)
    }

    fn level(&mut self, level: usize) -> (Expr, Kind) {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let (mut expr, mut kind) = self.level(level + 1);
        while let Some((_, operator)) = operators.iter().find(|(sign, _)| self.takes(sign)) {
            let (right, other) = self.level(level + 1);
            let changes = self.changes(&expr, true) || self.changes(&right, true);
            assert!(!changes, "{expr:?} or {right:?} changes something");
            kind = joined(*operator, kind, other);
            expr = two(*operator, expr, right);
        }
        (expr, kind)
    }

    fn unary(&mut self) -> (Expr, Kind) {
        if self.takes("!") {
            let (of, kind) = self.unary();
            assert_eq!(kind, Kind::Int, "! of {of:?}");
            return (Expr::Not(Box::new(of)), Kind::Int);
        }
        let (expr, kind) = self.primary();
        let by = if self.takes("++") {
            1
        } else if self.takes("--") {
            -1
        } else {
            return (expr, kind);
        };
        let Expr::Load(place) = expr else { panic!("{expr:?} is changed") };
        assert!(kind == Kind::Int && place.of != Type::Bool, "{place:?} is changed");
        (Expr::Step(place, by), Kind::Int)
    }

    fn primary(&mut self) -> (Expr, Kind) {
        let word = match self.next() {
            Token::Number(number) => return (Expr::Number(number), Kind::Int),
            Token::Sign("(") => {
                let inner = self.implication();
                self.expect(")");
                return inner;
            }
            Token::Word(word) => word,
            other => panic!("an expression is wanted, and there is {other:?}"),
        };
        match word.as_str() {
            "true" => return (Expr::Number(1), Kind::Int),
            "false" => return (Expr::Number(0), Kind::Int),
            "deadlock" => return (Expr::Deadlock, Kind::Constraint),
            _ => {}
        }
        match self.names.find(&word).cloned().unwrap_or_else(|| panic!("`{word}` is not known")) {
            Name::Number(number) => (Expr::Number(number), Kind::Int),
            Name::Variable(space, base, of) => {
                self.part(Place { space, base, indices: Vec::new(), of })
            }
            Name::Function(function) => self.called(function),
            other => panic!("`{word}` is {other:?}"),
        }
    }

    /// A part of a variable.
    fn part(&mut self, mut place: Place) -> (Expr, Kind) {
        loop {
            if self.takes("[") {
                let Type::Array(inner, count) = place.of.clone() else {
                    panic!("{place:?} is no array")
                };
                let index = self.pure(Kind::Int);
                self.expect("]");
                place.indices.push((index, inner.size(), count));
                place.of = (*inner).clone();
            } else if self.takes(".") {
                let field = self.name();
                let Type::Record(fields) = place.of.clone() else {
                    panic!("{place:?} has no parts")
                };
                let at = fields.iter().position(|(name, _)| *name == field);
                let at = at.unwrap_or_else(|| panic!("{place:?} has no {field}"));
                place.base += fields[..at].iter().map(|(_, of)| of.size()).sum::<usize>();
                place.of = fields[at].1.clone();
            } else {
                break;
            }
        }
        let kind = match &place.of {
            Type::Int(..) | Type::Bool => Kind::Int,
            Type::Clock => Kind::Clock,
            Type::Record(_) if place.space == Space::Global => Kind::Record,
            other => panic!("{other:?} as a value"),
        };
        (Expr::Load(place), kind)
    }

    fn called(&mut self, function: usize) -> (Expr, Kind) {
        self.expect("(");
        let mut given = Vec::new();
        while !self.takes(")") {
            if !given.is_empty() {
                self.expect(",");
            }
            let (one, kind) = self.expr();
            assert!(kind == Kind::Int && !self.changes(&one, true), "{one:?} is given");
            given.push(one);
        }
        let called = &self.names.fixed.functions[function];
        assert_eq!(called.takes.len(), given.len(), "what {} takes", called.name);
        let kind = if called.gives == Type::Void { Kind::Void } else { Kind::Int };
        (Expr::Call(function, given), kind)
    }

    /// Whether an expression changes a variable; also a local one, if `any`.
    pub(crate) fn changes(&self, expr: &Expr, any: bool) -> bool {
        let own = |place: &Place| any || place.space != Space::Local;
        match expr {
            Expr::Number(_) | Expr::Load(_) | Expr::Deadlock => false,
            Expr::Not(of) => self.changes(of, any),
            Expr::Two(_, a, b) => self.changes(a, any) || self.changes(b, any),
            Expr::Assign(place, of) => own(place) || self.changes(of, any),
            Expr::Step(place, _) | Expr::Copy(place, _) => own(place),
            Expr::Call(function, given) => {
                self.names.fixed.functions[*function].changes
                    || given.iter().any(|one| self.changes(one, any))
            }
        }
    }
}

fn two(operator: Operator, a: Expr, b: Expr) -> Expr {
    Expr::Two(operator, Box::new(a), Box::new(b))
}

fn is_constant(expr: &Expr) -> bool {
    match expr {
        Expr::Number(_) => true,
        Expr::Load(place) => {
            place.space == Space::Constant && place.indices.iter().all(|(at, ..)| is_constant(at))
        }
        Expr::Two(_, a, b) => is_constant(a) && is_constant(b),
        _ => false,
    }
}

/// Of two things about clocks, one of which need not hold.
fn either(a: Kind, b: Kind) -> Kind {
    match (a, b) {
        (Kind::Int, other) | (other, Kind::Int) => other,
        _ => Kind::Constraint,
    }
}

/// What an operator makes of two operands.
fn joined(operator: Operator, a: Kind, b: Kind) -> Kind {
    let known = a <= Kind::Constraint && b <= Kind::Constraint;
    match operator {
        Operator::And if known => a.max(b),
        Operator::Or if known => either(a, b),
        _ if (a, b) == (Kind::Int, Kind::Int) => Kind::Int,
        Operator::AtMost if (a, b) == (Kind::Clock, Kind::Int) => Kind::Invariant,
        Operator::AtLeast | Operator::Equal if (a, b) == (Kind::Clock, Kind::Int) => Kind::Guard,
        // Whole numbers of time say all only if bounds are closed, so this is for queries.
        Operator::Less if (a, b) == (Kind::Clock, Kind::Int) => Kind::Constraint,
        _ => panic!("{operator:?} of {a:?} and {b:?}"),
    }
}
