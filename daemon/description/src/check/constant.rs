//! Evaluates constant expressions and converts values to types (genom3.md 2.6, 3.3).

use genom_types::{Kind, Label, TypeId};
use serde_json::Value as Json;

use super::Checker;
use super::room::of_json;
use super::scope::Entity;
use super::value::{Refusal, Value};
use crate::diagnostic::Diagnostic;
use crate::model::{Constant, Span};
use crate::syntax::{Binary, Const, Expression, ExpressionKind, Literal, Quantity, Unary};

impl Checker {
    /// The value of an expression; `None` after an error that was reported.
    pub(super) fn evaluate(&mut self, expression: &Expression) -> Option<Value> {
        match &expression.kind {
            ExpressionKind::Error => None,
            ExpressionKind::Literal(literal) => Some(match literal {
                Literal::Boolean(v) => Value::Boolean(*v),
                Literal::Integer(v) => Value::Unsigned(*v),
                Literal::Float(v) => Value::Float(*v),
                Literal::Char(v) => Value::Char(*v),
                Literal::String(v) => Value::Text(v.clone()),
            }),
            ExpressionKind::Name(path) => match self.find(path, "constant")?.0 {
                Entity::Const(rank) => self.constant_values.get(rank).cloned().flatten(),
                Entity::Enumerator(ty, rank) => Some(Value::Enumerator(ty, rank)),
                // genom3.md 3.3 C2.
                other => {
                    let what = self.describe(other);
                    let message = format!("`{path}` is {what}, not a constant");
                    self.push(Diagnostic::error("E0302", path.span, message));
                    None
                }
            },
            ExpressionKind::Unary(op, operand) => {
                let value = self.evaluate(operand)?;
                let kind = value.kind();
                let result = value.unary(*op);
                if result.is_err() {
                    let message = format!("`{}` does not apply to {kind}", unary_text(*op));
                    self.push(Diagnostic::error("E0301", expression.span, message));
                }
                result.ok()
            }
            ExpressionKind::Chain(first, rest) => {
                let mut value = self.evaluate(first);
                for (op, right) in rest {
                    let right_value = self.evaluate(right);
                    value = match (value, right_value) {
                        (Some(a), Some(b)) => self.binary(*op, a, &b, right.span),
                        _ => None,
                    };
                }
                value
            }
        }
    }

    // genom3.md 3.3 C1.
    fn binary(&mut self, op: Binary, a: Value, b: &Value, span: Span) -> Option<Value> {
        let (left, right) = (a.kind(), b.kind());
        match a.binary(op, b) {
            Ok(value) => return Some(value),
            Err(Refusal::Zero) => {
                self.push(Diagnostic::error("E0312", span, "division by zero"));
            }
            Err(Refusal::Kind) => {
                let message = format!("`{}` does not apply to {left} and {right}", binary_text(op));
                self.push(Diagnostic::error("E0301", span, message));
            }
        }
        None
    }

    /// Evaluates a size, index, priority or stack size.
    // genom3.md 3.3 C3.
    pub(super) fn positive(&mut self, expression: &Expression) -> Option<u64> {
        let value = self.evaluate(expression)?;
        let number = value.to_unsigned();
        if number.is_none() {
            let message = "a non-negative integer constant is required here";
            self.push(Diagnostic::error("E0303", expression.span, message));
        }
        number
    }

    pub(super) fn positive_u32(&mut self, expression: &Expression) -> Option<u32> {
        let value = self.positive(expression)?;
        let number = u32::try_from(value).ok();
        if number.is_none() {
            let message = format!("{value} is too large, the greatest is {}", u32::MAX);
            self.push(Diagnostic::error("E0303", expression.span, message));
        }
        number
    }

    /// Evaluates a time, in seconds.
    // genom3.md 3.3 C4, 3.5 P8.
    pub(super) fn seconds(&mut self, quantity: &Quantity, what: &str) -> Option<f64> {
        let value = self.evaluate(&quantity.value)?;
        let span = quantity.value.span;
        let Some(number) = value.to_float() else {
            let message = format!("{what} must be a number, this is {}", value.kind());
            self.push(Diagnostic::error("E0304", span, message));
            return None;
        };
        let seconds = number / quantity.unit.per_second();
        if !(0.0..1e10).contains(&seconds) {
            let message = format!("{what} must be positive, and less than 300 years");
            self.push(Diagnostic::error("E0508", span, message));
            return None;
        }
        Some(seconds)
    }

    pub(super) fn constant(&mut self, dcl: &Const) {
        let ty = self.type_spec(&dcl.ty);
        let value = self.evaluate(&dcl.value);
        let value = match (ty, value) {
            (Some(ty), Some(value)) => self.fit(value, ty, dcl.value.span, "E0305"),
            _ => None,
        };
        if ty.is_none() || value.is_none() {
            self.lost.insert(dcl.name.text.clone());
        }
        let Some(ty) = ty else { return };
        if self.declare(&dcl.name, Entity::Const(self.constants.len())) {
            let json = value.as_ref().map_or(Json::Null, |value| self.json(value, ty));
            // A constant may refer to another one, whose whole text is then copied.
            if !self.reserve(2 * of_json(&json), dcl.name.span) {
                return;
            }
            self.constants.push(Constant {
                name: self.scopes.full_name(self.scope).join(&dcl.name.text),
                ty,
                value: json,
                span: dcl.name.span,
            });
            self.constant_values.push(value);
        }
    }

    /// Converts a value to type `ty`; if that is impossible, reports code `refused`.
    // genom3.md 3.3 C5, C6.
    pub(super) fn fit(
        &mut self,
        value: Value,
        ty: TypeId,
        span: Span,
        refused: &'static str,
    ) -> Option<Value> {
        let resolved = self.types.resolve(ty);
        // Enums are large and compared by type; of other kinds a copy is cheap.
        let kind = match self.types.kind(resolved) {
            Kind::Enum { .. } => None,
            Kind::Struct { .. } | Kind::Exception { .. } | Kind::Union { .. } => Some(Kind::Any),
            small => Some(small.clone()),
        };
        let Some(kind) = kind else {
            return self.fit_enum(value, resolved, span, refused);
        };
        let fitted = match &kind {
            Kind::Optional { element } => return self.fit(value, *element, span, refused),
            Kind::Boolean => matches!(value, Value::Boolean(_)).then(|| value.clone()),
            Kind::Octet | Kind::UnsignedShort | Kind::UnsignedLong | Kind::UnsignedLongLong => {
                value.to_unsigned().map(Value::Unsigned)
            }
            Kind::Short | Kind::Long | Kind::LongLong => value
                .to_integer()
                .map(|wide| i64::try_from(wide).map_or(value.clone(), Value::Signed)),
            Kind::Float | Kind::Double => value.to_float().map(Value::Float),
            Kind::Char => match &value {
                Value::Char(code) => Some(Value::Char(*code)),
                Value::Text(text) => {
                    if text.chars().count() > 1 {
                        let message = format!("only the first character of {text:?} is kept");
                        self.push(Diagnostic::warning("W0904", span, message));
                    }
                    Some(Value::Char(text.bytes().next().unwrap_or(0)))
                }
                _ => None,
            },
            Kind::String { .. } => matches!(value, Value::Text(_)).then(|| value.clone()),
            _ => {
                if !self.is_error(resolved) {
                    let name = self.type_name(ty);
                    let message = format!("{name} cannot be the type of a constant");
                    self.push(Diagnostic::error("E0306", span, message));
                }
                return None;
            }
        };
        match &fitted {
            Some(fitted) => self.check_range(fitted, &kind, span),
            None => {
                let name = self.type_name(ty);
                let mut error = Diagnostic::error(
                    refused,
                    span,
                    format!("{} cannot become {name}", value.kind()),
                );
                if kind == Kind::Boolean {
                    error = error.help("write `TRUE` or `FALSE`");
                }
                self.push(error);
            }
        }
        fitted
    }

    fn fit_enum(
        &mut self,
        value: Value,
        ty: TypeId,
        span: Span,
        refused: &'static str,
    ) -> Option<Value> {
        match value {
            Value::Enumerator(other, rank) if self.types.equal(other, ty) => {
                Some(Value::Enumerator(ty, rank))
            }
            other => {
                let message = format!("{} cannot become {}", other.kind(), self.type_name(ty));
                self.push(Diagnostic::error(refused, span, message));
                None
            }
        }
    }

    /// genom3.md 3.10: GenoM3 checks no ranges; here it is a warning.
    fn check_range(&mut self, value: &Value, kind: &Kind, span: Span) {
        let range = match kind {
            Kind::Octet => 0..=i128::from(u8::MAX),
            Kind::UnsignedShort => 0..=i128::from(u16::MAX),
            Kind::UnsignedLong => 0..=i128::from(u32::MAX),
            Kind::Short => i16::MIN.into()..=i16::MAX.into(),
            Kind::Long => i32::MIN.into()..=i32::MAX.into(),
            Kind::LongLong => i64::MIN.into()..=i64::MAX.into(),
            Kind::String { bound: Some(bound) } => {
                if let Value::Text(text) = value
                    && text.len() >= *bound as usize
                {
                    let message = format!(
                        "{} bytes and the final NUL do not fit into string<{bound}>",
                        text.len()
                    );
                    self.push(Diagnostic::warning("W0904", span, message));
                }
                return;
            }
            _ => return,
        };
        if let Some(number) = value.to_integer()
            && !range.contains(&number)
        {
            let message = format!("{number} is out of range, {} to {}", range.start(), range.end());
            self.push(Diagnostic::warning("W0904", span, message));
        }
    }

    /// JSON of a converted value (genom3.md appendix A, booleans as `true` and `false`).
    pub(super) fn json(&self, value: &Value, ty: TypeId) -> Json {
        match value {
            Value::Boolean(v) => Json::from(*v),
            Value::Unsigned(v) => Json::from(*v),
            Value::Signed(v) => Json::from(*v),
            Value::Float(v) => Json::from(*v),
            Value::Char(v) => Json::from(char::from(*v).to_string()),
            Value::Text(v) => Json::from(v.as_str()),
            Value::Enumerator(_, rank) => match self.types.resolved(ty) {
                Kind::Enum { enumerators, .. } => {
                    enumerators.get(*rank as usize).map_or(Json::Null, |n| n.as_str().into())
                }
                Kind::Optional { element } => self.json(value, *element),
                _ => Json::Null,
            },
        }
    }

    /// A converted value as the label of a union.
    pub(super) fn label(value: &Value) -> Option<Label> {
        match value {
            Value::Boolean(v) => Some(Label::Value((*v).into())),
            // The char's sign follows C, where it is int8_t.
            Value::Char(v) => Some(Label::Value(i128::from(v.cast_signed()))),
            Value::Enumerator(_, rank) => Some(Label::Value((*rank).into())),
            other => other.to_integer().map(Label::Value),
        }
    }
}

fn unary_text(op: Unary) -> &'static str {
    match op {
        Unary::Minus => "-",
        Unary::Plus => "+",
        Unary::Not => "~",
    }
}

fn binary_text(op: Binary) -> &'static str {
    match op {
        Binary::Or => "|",
        Binary::Xor => "^",
        Binary::And => "&",
        Binary::ShiftLeft => "<<",
        Binary::ShiftRight => ">>",
        Binary::Add => "+",
        Binary::Subtract => "-",
        Binary::Multiply => "*",
        Binary::Divide => "/",
        Binary::Remainder => "%",
    }
}
