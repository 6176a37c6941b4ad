//! Values of constant expressions: operators and conversions (genom3.md 2.6).

use genom_types::TypeId;

use crate::syntax::{Binary, Unary};

/// A value, of the kinds that expressions have.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Boolean(bool),
    Unsigned(u64),
    Signed(i64),
    Float(f64),
    Char(u8),
    Text(String),
    /// Its enum, and its index there.
    Enumerator(TypeId, u32),
}

/// Why an operator has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// The operator does not accept such values.
    Kind,
    /// Division or remainder by zero.
    Zero,
}

impl Value {
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Value::Boolean(_) => "a boolean",
            Value::Unsigned(_) | Value::Signed(_) => "an integer",
            Value::Float(_) => "a floating point number",
            Value::Char(_) => "a character",
            Value::Text(_) => "a string",
            Value::Enumerator(..) => "an enumerator",
        }
    }

    pub(super) fn to_unsigned(&self) -> Option<u64> {
        match *self {
            Value::Unsigned(v) => Some(v),
            Value::Signed(v) => u64::try_from(v).ok(),
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Value::Float(v) if v >= 0.0 && v.fract() == 0.0 && v < 18_446_744_073_709_551_616.0 => {
                Some(v as u64)
            }
            _ => None,
        }
    }

    /// As a signed integer; the caller checks the range of its type.
    pub(super) fn to_integer(&self) -> Option<i128> {
        match *self {
            Value::Unsigned(v) => Some(v.into()),
            Value::Signed(v) => Some(v.into()),
            #[allow(clippy::cast_possible_truncation)]
            Value::Float(v) if v.fract() == 0.0 && v.abs() < 1e30 => Some(v as i128),
            _ => None,
        }
    }

    #[allow(clippy::cast_precision_loss)]
    pub(super) fn to_float(&self) -> Option<f64> {
        match *self {
            Value::Unsigned(v) => Some(v as f64),
            Value::Signed(v) => Some(v as f64),
            Value::Float(v) => Some(v),
            _ => None,
        }
    }

    #[allow(clippy::cast_possible_wrap)]
    fn as_signed(&self) -> Option<i64> {
        match *self {
            Value::Unsigned(v) => Some(v as i64),
            Value::Signed(v) => Some(v),
            _ => None,
        }
    }

    pub(super) fn unary(self, op: Unary) -> Result<Value, Refusal> {
        match (op, self) {
            (Unary::Minus, Value::Signed(v)) => Ok(Value::Signed(v.wrapping_neg())),
            #[allow(clippy::cast_possible_wrap)]
            (Unary::Minus, Value::Unsigned(v)) => Ok(Value::Signed((v as i64).wrapping_neg())),
            (Unary::Minus, Value::Float(v)) => Ok(Value::Float(-v)),
            (Unary::Plus, v @ (Value::Signed(_) | Value::Unsigned(_) | Value::Float(_))) => Ok(v),
            (Unary::Not, Value::Boolean(v)) => Ok(Value::Boolean(!v)),
            (Unary::Not, Value::Unsigned(v)) => Ok(Value::Unsigned(!v)),
            (Unary::Not, Value::Signed(v)) => Ok(Value::Signed(!v)),
            _ => Err(Refusal::Kind),
        }
    }

    pub(super) fn binary(self, op: Binary, right: &Value) -> Result<Value, Refusal> {
        use Value::{Float, Signed, Unsigned};
        if matches!(op, Binary::ShiftLeft | Binary::ShiftRight) {
            let by = right.to_unsigned().filter(|_| !matches!(right, Float(_)));
            let by = u32::try_from(by.ok_or(Refusal::Kind)?).unwrap_or(u32::MAX);
            let left = op == Binary::ShiftLeft;
            return match self {
                Unsigned(v) if left => Ok(Unsigned(v.checked_shl(by).unwrap_or(0))),
                Unsigned(v) => Ok(Unsigned(v.checked_shr(by).unwrap_or(0))),
                Signed(v) if left => Ok(Signed(v.checked_shl(by).unwrap_or(0))),
                Signed(v) => Ok(Signed(v >> by.min(63))),
                _ => Err(Refusal::Kind),
            };
        }
        if let (Unsigned(a), Unsigned(b)) = (&self, right) {
            return unsigned(op, *a, *b).map(Unsigned);
        }
        if let (Some(a), Some(b)) = (self.as_signed(), right.as_signed()) {
            return signed(op, a, b).map(Signed);
        }
        match (self.to_float(), right.to_float(), op) {
            (Some(a), Some(b), Binary::Add) => Ok(Float(a + b)),
            (Some(a), Some(b), Binary::Subtract) => Ok(Float(a - b)),
            (Some(a), Some(b), Binary::Multiply) => Ok(Float(a * b)),
            (Some(_), Some(0.0), Binary::Divide) => Err(Refusal::Zero),
            (Some(a), Some(b), Binary::Divide) => Ok(Float(a / b)),
            _ => Err(Refusal::Kind),
        }
    }
}

fn unsigned(op: Binary, a: u64, b: u64) -> Result<u64, Refusal> {
    Ok(match op {
        Binary::Add => a.wrapping_add(b),
        Binary::Subtract => a.wrapping_sub(b),
        Binary::Multiply => a.wrapping_mul(b),
        Binary::Divide => a.checked_div(b).ok_or(Refusal::Zero)?,
        Binary::Remainder => a.checked_rem(b).ok_or(Refusal::Zero)?,
        Binary::And => a & b,
        Binary::Or => a | b,
        Binary::Xor => a ^ b,
        Binary::ShiftLeft | Binary::ShiftRight => return Err(Refusal::Kind),
    })
}

fn signed(op: Binary, a: i64, b: i64) -> Result<i64, Refusal> {
    Ok(match op {
        Binary::Add => a.wrapping_add(b),
        Binary::Subtract => a.wrapping_sub(b),
        Binary::Multiply => a.wrapping_mul(b),
        Binary::Divide | Binary::Remainder if b == 0 => return Err(Refusal::Zero),
        Binary::Divide => a.wrapping_div(b),
        Binary::Remainder => a.wrapping_rem(b),
        Binary::And => a & b,
        Binary::Or => a | b,
        Binary::Xor => a ^ b,
        Binary::ShiftLeft | Binary::ShiftRight => return Err(Refusal::Kind),
    })
}
