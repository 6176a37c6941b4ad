//! From a value in memory to JSON.

use serde_json::{Map, Number, Value};

use crate::graph::{Scalar, Shape};
use crate::layout::MAX_NESTING;
use crate::memory::View;

/// The JSON of a value; what is nested deeper than [`MAX_NESTING`] sequences is `null`.
pub(crate) fn write(value: View<'_>) -> Value {
    at(value, 0)
}

fn at(value: View<'_>, depth: usize) -> Value {
    match &value.node().shape {
        Shape::Scalar(_) => scalar(value),
        Shape::Enum { names, .. } => {
            let name = usize::try_from(value.integer()).ok().and_then(|rank| names.get(rank));
            Value::String(name.map_or("<invalid>", String::as_str).to_owned())
        }
        Shape::Text { .. } => Value::String(String::from_utf8_lossy(value.text()).into_owned()),
        Shape::Array { .. } => value.elements().map(|element| at(element, depth)).collect(),
        Shape::Sequence { .. } if depth >= MAX_NESTING => Value::Null,
        Shape::Sequence { .. } => value.elements().map(|element| at(element, depth + 1)).collect(),
        Shape::Optional { .. } => value.value().map_or(Value::Null, |inner| at(inner, depth)),
        Shape::Struct { .. } => Value::Object(
            value.members().map(|(name, member)| (name.to_owned(), at(member, depth))).collect(),
        ),
        Shape::Union { .. } => {
            let switch = value.switch().map_or(Value::Null, |switch| at(switch, depth));
            let member: Map<String, Value> = value
                .active()
                .map(|(name, member)| (name.to_owned(), at(member, depth)))
                .into_iter()
                .collect();
            let mut whole = Map::new();
            whole.insert("d".to_owned(), switch);
            whole.insert("u".to_owned(), Value::Object(member));
            Value::Object(whole)
        }
        Shape::Native => Value::Null,
    }
}

/// A scalar, or the number of an enumerator.
pub(super) fn scalar(value: View<'_>) -> Value {
    match value.node().shape {
        Shape::Scalar(Scalar::Boolean) => Value::Bool(value.integer() != 0),
        // Truncation is intended: the code of the character, as a byte.
        Shape::Scalar(Scalar::Char) => Value::String(char::from(value.integer() as u8).to_string()),
        Shape::Scalar(Scalar::Float) => float(value.real() as f32),
        Shape::Scalar(Scalar::Double) => double(value.real()),
        _ => integer(value.integer()),
    }
}

fn integer(value: i128) -> Value {
    match i64::try_from(value) {
        Ok(value) => Value::from(value),
        Err(_) => u64::try_from(value).map_or(Value::Null, Value::from),
    }
}

fn double(value: f64) -> Value {
    match Number::from_f64(value) {
        Some(number) => Value::Number(number),
        None if value.is_nan() => Value::Null,
        None if value > 0.0 => Value::from("inf"),
        None => Value::from("-inf"),
    }
}

/// The shortest number that reads back as this float: 0.1, not 0.10000000149011612.
fn float(value: f32) -> Value {
    let short = value.to_string().parse::<f64>().unwrap_or(value.into());
    double(if short as f32 == value { short } else { value.into() })
}
