//! Conditional groups: `#if` and its family, and the expressions they test.

use super::state::Conditional;
use super::{Kind, PToken, Preprocessor, Text};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// Deepest nesting of parentheses and unary operators in an `#if` expression.
const MAX_DEPTH: usize = 100;

impl Preprocessor<'_> {
    /// `#if`, `#ifdef`, `#ifndef` in text that is read.
    pub(super) fn begin_condition(&mut self, hash: PToken, name: PToken, directive: &str) {
        let line = self.read_line();
        let taken = match directive {
            "if" => self.evaluate(name, line),
            _ => {
                self.is_defined(name, &line, directive).is_some_and(|d| d == (directive == "ifdef"))
            }
        };
        let span = Span { end: name.span.end, ..hash.span };
        if let Some(open) = self.open.last_mut() {
            open.conditionals.push(Conditional { span, taken, last: None });
        }
        if !taken {
            self.skip();
        }
    }

    /// `#elif`, `#else`, `#endif` at the end of a group that was read.
    pub(super) fn next_condition(&mut self, hash: PToken, name: PToken, directive: &str) {
        self.read_line_quietly();
        let span = Span { end: name.span.end, ..hash.span };
        if directive == "endif" {
            if self.open.last_mut().and_then(|open| open.conditionals.pop()).is_none() {
                self.unbalanced(span, directive);
            }
            return;
        }
        if self.open.last().is_none_or(|open| open.conditionals.is_empty()) {
            self.unbalanced(span, directive);
            return;
        }
        self.check_order(span, directive);
        self.skip();
    }

    /// Skips groups until one is to be read or the conditional ends.
    fn skip(&mut self) {
        let mut depth = 0_usize;
        loop {
            self.set_quiet(true);
            let hash = self.begin_directive();
            if hash.kind == Kind::End {
                break;
            }
            if hash.kind == Kind::Newline {
                continue;
            }
            if !hash.first || self.text(hash) != "#" {
                self.skip_line();
                continue;
            }
            let name = self.line_token();
            let directive = self.text(name).to_owned();
            let span = Span { end: name.span.end, ..hash.span };
            if matches!(name.kind, Kind::Newline | Kind::End) {
                continue;
            }
            match directive.as_str() {
                "if" | "ifdef" | "ifndef" => depth += 1,
                "endif" if depth > 0 => depth -= 1,
                "endif" => {
                    self.skip_line();
                    if let Some(open) = self.open.last_mut() {
                        open.conditionals.pop();
                    }
                    break;
                }
                "else" | "elif" if depth == 0 => {
                    self.check_order(span, &directive);
                    if self.branch(name, directive == "else") {
                        break;
                    }
                    continue;
                }
                _ => {}
            }
            self.skip_line();
        }
        self.end_directive();
        self.set_quiet(false);
    }

    /// Whether the group after an `#else` or `#elif` is read.
    fn branch(&mut self, name: PToken, is_else: bool) -> bool {
        let before = self.open.last().and_then(|open| open.conditionals.last());
        let already = before.is_none_or(|conditional| conditional.taken);
        let taken = if already || is_else {
            self.skip_line();
            !already
        } else {
            self.set_quiet(false);
            let line = self.read_line();
            self.evaluate(name, line)
        };
        let conditional = self.open.last_mut().and_then(|open| open.conditionals.last_mut());
        if let Some(conditional) = conditional {
            conditional.taken |= taken;
        }
        taken
    }

    /// Reports `#else` and `#elif` after an `#else`.
    fn check_order(&mut self, span: Span, directive: &str) {
        let conditional = self.open.last_mut().and_then(|open| open.conditionals.last_mut());
        let Some(conditional) = conditional else { return };
        match conditional.last {
            Some(last) => self.diagnostics.push(
                Diagnostic::error("E0129", span, format!("`#{directive}` after `#else`"))
                    .note(last, "the `#else` is here"),
            ),
            None if directive == "else" => conditional.last = Some(span),
            None => {}
        }
    }

    fn unbalanced(&mut self, span: Span, directive: &str) {
        let message = format!("`#{directive}` without `#if`");
        self.diagnostics.push(Diagnostic::error("E0129", span, message));
    }

    fn is_defined(&mut self, name: PToken, line: &[PToken], directive: &str) -> Option<bool> {
        match line.first() {
            Some(token) if token.kind == Kind::Identifier => {
                Some(self.macros.contains_key(self.text(*token)))
            }
            other => {
                let span = other.map_or(name.span, |token| token.span);
                let message = format!("`#{directive}` must name a macro");
                self.diagnostics.push(Diagnostic::error("E0123", span, message));
                None
            }
        }
    }

    /// The truth of an `#if` expression; false when it is not valid.
    fn evaluate(&mut self, name: PToken, line: Vec<PToken>) -> bool {
        if self.fatal {
            return false;
        }
        let line = self.answer_defined(line);
        let line = self.expand_list(line);
        let mut evaluation =
            Evaluation { preprocessor: self, line: &line, at: 0, depth: 0, dead: 0 };
        let result = evaluation.conditional().and_then(|value| match evaluation.peek() {
            None => Ok(value),
            Some(token) => Err((token.span, "an operator is expected here".to_owned())),
        });
        match result {
            Ok(value) => value.number != 0,
            Err((span, message)) => {
                let span = if span == Span::default() { name.span } else { span };
                let message = format!("in `#{}`: {message}", self.text(name));
                self.diagnostics.push(Diagnostic::error("E0128", span, message));
                false
            }
        }
    }

    /// Replaces `defined X` and `defined(X)` before macros are expanded.
    fn answer_defined(&mut self, line: Vec<PToken>) -> Vec<PToken> {
        let mut out = Vec::with_capacity(line.len());
        let mut answers: [Option<Text>; 2] = [None, None];
        let mut at = 0;
        while let Some(&token) = line.get(at) {
            at += 1;
            let is_defined = token.kind == Kind::Identifier && self.text(token) == "defined";
            let text = |rank: usize| line.get(rank).map_or("", |token| self.text(*token));
            let (name, after) = match (text(at), text(at + 2)) {
                ("(", ")") => (line.get(at + 1), at + 3),
                _ => (line.get(at), at + 1),
            };
            match name.filter(|name| is_defined && name.kind == Kind::Identifier) {
                Some(name) => {
                    let known = usize::from(self.macros.contains_key(self.text(*name)));
                    let text = match answers[known] {
                        Some(text) => text,
                        None => self.scratch(["0", "1"][known]),
                    };
                    answers[known] = Some(text);
                    out.push(PToken { kind: Kind::Number, text, first: false, ..token });
                    at = after;
                }
                None => out.push(token),
            }
        }
        out
    }
}

/// A value of an `#if` expression: 64 bits, signed or not.
#[derive(Clone, Copy)]
struct Value {
    number: i64,
    unsigned: bool,
}

type Computed = Result<Value, (Span, String)>;

/// State of evaluating one `#if` expression.
struct Evaluation<'e, 'a> {
    preprocessor: &'e Preprocessor<'a>,
    line: &'e [PToken],
    at: usize,
    depth: usize,
    /// Depth of operands that are not evaluated, such as the right one of `0 &&`: a division by
    /// zero is no error there.
    dead: usize,
}

/// Binary operators by precedence, loosest first; longer spellings before their prefixes.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<=", ">=", "<", ">"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl Evaluation<'_, '_> {
    fn peek(&self) -> Option<PToken> {
        self.line.get(self.at).copied()
    }

    fn text(&self, ahead: usize) -> &str {
        self.line.get(self.at + ahead).map_or("", |token| self.preprocessor.text(*token))
    }

    /// The operator at this position: `&`, `|` and `=` are tokens each, so `&&` is two side by
    /// side.
    fn operator(&self) -> (String, usize) {
        let first = self.text(0);
        let next = self.line.get(self.at + 1).filter(|next| !next.space);
        let second = next.map_or("", |next| self.preprocessor.text(*next));
        match (first, second) {
            ("&", "&") | ("|", "|") | ("=" | "!" | "<" | ">", "=") => {
                (format!("{first}{second}"), 2)
            }
            _ => (first.to_owned(), 1),
        }
    }

    fn conditional(&mut self) -> Computed {
        self.enter()?;
        let condition = self.binary(0)?;
        let value = if self.text(0) == "?" {
            self.at += 1;
            let holds = condition.number != 0;
            let yes = self.operand(!holds, Self::conditional)?;
            if self.text(0) != ":" {
                return Err(self.expected("`:`"));
            }
            self.at += 1;
            let no = self.operand(holds, Self::conditional)?;
            if condition.number == 0 { no } else { yes }
        } else {
            condition
        };
        self.depth -= 1;
        Ok(value)
    }

    fn binary(&mut self, level: usize) -> Computed {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        loop {
            let (operator, length) = self.operator();
            if !operators.contains(&operator.as_str()) {
                return Ok(left);
            }
            let span = self.peek().map_or(Span::default(), |token| token.span);
            self.at += length;
            let decided = match operator.as_str() {
                "&&" => left.number == 0,
                "||" => left.number != 0,
                _ => false,
            };
            let right = self.operand(decided, |this| this.binary(level + 1))?;
            left = match apply(&operator, left, right) {
                Some(value) => value,
                None if self.dead > 0 => truth(false),
                None => return Err((span, "division by zero".to_owned())),
            };
        }
    }

    /// Reads an operand; with `dead` it is not evaluated.
    fn operand(&mut self, dead: bool, read: impl FnOnce(&mut Self) -> Computed) -> Computed {
        self.dead += usize::from(dead);
        let value = read(self);
        self.dead -= usize::from(dead);
        value
    }

    fn unary(&mut self) -> Computed {
        self.enter()?;
        let sign = self.text(0).to_owned();
        let value = match sign.as_str() {
            "-" | "+" | "~" | "!" => {
                self.at += 1;
                let value = self.unary()?;
                match sign.as_str() {
                    "-" => Value { number: value.number.wrapping_neg(), ..value },
                    "~" => Value { number: !value.number, ..value },
                    "!" => truth(value.number == 0),
                    _ => value,
                }
            }
            _ => self.primary()?,
        };
        self.depth -= 1;
        Ok(value)
    }

    fn primary(&mut self) -> Computed {
        let Some(token) = self.peek() else { return Err(self.expected("a value")) };
        let text = self.preprocessor.text(token);
        self.at += 1;
        match token.kind {
            Kind::Punctuation if text == "(" => {
                let value = self.conditional()?;
                if self.text(0) != ")" {
                    return Err(self.expected("`)`"));
                }
                self.at += 1;
                Ok(value)
            }
            Kind::Number => {
                number(text).ok_or_else(|| (token.span, format!("`{text}` is not an integer")))
            }
            Kind::Char => {
                let value = crate::lex::character(text).unwrap_or_default();
                Ok(Value { number: i64::from(value), unsigned: false })
            }
            // A name that is no macro is 0 (C99 6.10.1).
            Kind::Identifier => Ok(truth(false)),
            _ => Err((token.span, format!("a value is expected, not `{text}`"))),
        }
    }

    fn enter(&mut self) -> Result<(), (Span, String)> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let span = self.peek().map_or(Span::default(), |token| token.span);
            return Err((span, format!("the expression is nested more than {MAX_DEPTH} deep")));
        }
        Ok(())
    }

    fn expected(&self, what: &str) -> (Span, String) {
        let here = self.peek().or(self.line.last().copied());
        (here.map_or(Span::default(), |token| token.span), format!("{what} is expected"))
    }
}

fn truth(value: bool) -> Value {
    Value { number: i64::from(value), unsigned: false }
}

/// The value of a number. A version (`__GENOM__` is `2.99.41`) counts as its first part, as in
/// GenoM3; a number with a fraction is not valid.
fn number(text: &str) -> Option<Value> {
    let text = match text.split_once('.') {
        Some((first, rest)) if rest.contains('.') => first,
        _ => text,
    };
    let digits = text.trim_end_matches(['u', 'U', 'l', 'L']);
    let suffix = text.get(digits.len()..).unwrap_or_default();
    let lower = digits.to_ascii_lowercase();
    let value = match lower.strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16),
        None if lower.starts_with('0') => u64::from_str_radix(&lower, 8),
        None => lower.parse(),
    };
    let value = value.ok()?;
    let unsigned = suffix.contains(['u', 'U']) || value > i64::MAX.cast_unsigned();
    Some(Value { number: value.cast_signed(), unsigned })
}

/// The result of a binary operator; `None` for a division by zero.
fn apply(operator: &str, left: Value, right: Value) -> Option<Value> {
    let (a, b) = (left.number, right.number);
    let (ua, ub) = (a.cast_unsigned(), b.cast_unsigned());
    let unsigned = left.unsigned || right.unsigned;
    if matches!(operator, "/" | "%") && b == 0 {
        return None;
    }
    let value = |number| Value { number, unsigned };
    let shift = u32::try_from(ub & 63).unwrap_or(0);
    Some(match operator {
        "||" => truth(a != 0 || b != 0),
        "&&" => truth(a != 0 && b != 0),
        "==" => truth(a == b),
        "!=" => truth(a != b),
        "<" => truth(if unsigned { ua < ub } else { a < b }),
        ">" => truth(if unsigned { ua > ub } else { a > b }),
        "<=" => truth(if unsigned { ua <= ub } else { a <= b }),
        ">=" => truth(if unsigned { ua >= ub } else { a >= b }),
        "|" => value(a | b),
        "^" => value(a ^ b),
        "&" => value(a & b),
        "<<" => Value { number: a << shift, unsigned: left.unsigned },
        ">>" if left.unsigned => Value { number: (ua >> shift).cast_signed(), unsigned: true },
        ">>" => Value { number: a >> shift, unsigned: false },
        "+" => value(a.wrapping_add(b)),
        "-" => value(a.wrapping_sub(b)),
        "*" => value(a.wrapping_mul(b)),
        "/" if unsigned => value((ua / ub).cast_signed()),
        "/" => value(a.wrapping_div(b)),
        "%" if unsigned => value((ua % ub).cast_signed()),
        _ => value(a.wrapping_rem(b)),
    })
}
