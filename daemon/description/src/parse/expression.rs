//! Constant expressions (genom3.md 2.6).

use super::{Parsed, Parser};
use crate::diagnostic::Diagnostic;
use crate::syntax::{Binary, Expression, ExpressionKind, Literal, Text, Unary};
use crate::token::TokenKind;

/// Operators from the loosest to the tightest.
const LEVELS: [&[(&str, Binary)]; 6] = [
    &[("|", Binary::Or)],
    &[("^", Binary::Xor)],
    &[("&", Binary::And)],
    &[("<<", Binary::ShiftLeft), (">>", Binary::ShiftRight)],
    &[("+", Binary::Add), ("-", Binary::Subtract)],
    &[("*", Binary::Multiply), ("/", Binary::Divide), ("%", Binary::Remainder)],
];

impl Expression {
    /// Whether it ends in `a >> b`, which is often meant as the end of two templates.
    pub(crate) fn ends_in_right_shift(&self) -> bool {
        matches!(&self.kind, ExpressionKind::Chain(_, rest)
            if rest.last().is_some_and(|(op, _)| *op == Binary::ShiftRight))
    }
}

impl Parser<'_> {
    pub(super) fn expression(&mut self) -> Parsed<Expression> {
        self.level(0)
    }

    fn level(&mut self, level: usize) -> Parsed<Expression> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let start = self.span();
        let first = self.level(level + 1)?;
        let mut rest = Vec::new();
        while let Some((_, op)) = operators.iter().find(|(text, _)| self.is(text)) {
            self.bump();
            rest.push((*op, self.level(level + 1)?));
        }
        if rest.is_empty() {
            return Ok(first);
        }
        let kind = ExpressionKind::Chain(Box::new(first), rest);
        Ok(Expression { kind, span: self.since(start) })
    }

    fn unary(&mut self) -> Parsed<Expression> {
        let start = self.span();
        let operator = match self.kind() {
            TokenKind::Punctuation("-") => Unary::Minus,
            TokenKind::Punctuation("+") => Unary::Plus,
            TokenKind::Punctuation("~") => Unary::Not,
            _ => return self.primary(),
        };
        self.bump();
        let operand = self.primary()?;
        let kind = ExpressionKind::Unary(operator, Box::new(operand));
        Ok(Expression { kind, span: self.since(start) })
    }

    fn primary(&mut self) -> Parsed<Expression> {
        let start = self.span();
        let kind = match self.kind() {
            TokenKind::Punctuation("(") => {
                self.bump();
                let inner = self.nested(Self::expression)?;
                self.expect(")")?;
                return Ok(Expression { span: self.since(start), ..inner });
            }
            TokenKind::Identifier(_) | TokenKind::Punctuation("::") => {
                ExpressionKind::Name(self.path("a constant")?)
            }
            TokenKind::String(_) => ExpressionKind::Literal(Literal::String(self.text()?.text)),
            other => {
                let literal = match other {
                    TokenKind::Keyword("TRUE") => Literal::Boolean(true),
                    TokenKind::Keyword("FALSE") => Literal::Boolean(false),
                    TokenKind::Integer(value) => Literal::Integer(*value),
                    TokenKind::Float(value) => Literal::Float(*value),
                    TokenKind::Char(code) => Literal::Char(*code),
                    // genom3.md 3.1 L9.
                    TokenKind::Fixed => {
                        let error =
                            Diagnostic::error("E0109", start, "fixed point numbers do not exist")
                                .help("remove the suffix `d`");
                        self.report(error);
                        self.bump();
                        return Ok(Expression { kind: ExpressionKind::Error, span: start });
                    }
                    _ => return self.unexpected("a value"),
                };
                self.bump();
                ExpressionKind::Literal(literal)
            }
        };
        Ok(Expression { kind, span: self.since(start) })
    }

    /// One or more string literals, joined.
    pub(super) fn text(&mut self) -> Parsed<Text> {
        let start = self.span();
        let mut text = String::new();
        if !matches!(self.kind(), TokenKind::String(_)) {
            return self.unexpected("a string");
        }
        while let TokenKind::String(part) = self.kind() {
            text.push_str(part);
            self.bump();
        }
        Ok(Text { text, span: self.since(start) })
    }
}
