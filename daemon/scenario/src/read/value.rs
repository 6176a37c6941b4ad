//! Values of TOML as the JSON of the control plane.

use std::fmt;

use serde_json::{Map, Number, Value};
use toml::Spanned;
use toml::de::DeValue;

use super::found::Found;

/// The value as the daemon writes it: infinities are `"inf"` and `"-inf"`, NaN is `null`.
pub(crate) fn json(value: &Spanned<DeValue<'_>>, found: &Found) -> Option<Value> {
    let refused = |message: String| {
        found.add(value.span(), message, None);
        None
    };
    Some(match value.get_ref() {
        DeValue::String(text) => Value::from(text.as_ref()),
        DeValue::Boolean(is) => Value::from(*is),
        DeValue::Integer(digits) => {
            let (text, radix) = (digits.as_str(), digits.radix());
            let number = i64::from_str_radix(text, radix).map(Number::from);
            let number = number.or_else(|_| u64::from_str_radix(text, radix).map(Number::from));
            match number {
                Ok(number) => Value::Number(number),
                Err(_) => return refused(format!("{digits} does not fit 64 bits")),
            }
        }
        DeValue::Float(digits) => match digits.as_str().parse::<f64>() {
            Ok(number) if number.is_nan() => Value::Null,
            Ok(f64::INFINITY) => Value::from("inf"),
            Ok(f64::NEG_INFINITY) => Value::from("-inf"),
            Ok(number) => Value::from(number),
            Err(_) => return refused(format!("{digits} is no number")),
        },
        DeValue::Array(elements) => {
            elements.iter().map(|element| json(element, found)).collect::<Option<_>>()?
        }
        DeValue::Table(members) => {
            let member = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                let key: &std::borrow::Cow<'_, str> = key.get_ref();
                Some((key.to_string(), json(value, found)?))
            };
            Value::Object(members.iter().map(member).collect::<Option<Map<_, _>>>()?)
        }
        DeValue::Datetime(_) => return refused("no type of a component is a date".to_owned()),
    })
}

/// What a value is, for messages.
pub(crate) struct Shown<'v, 'i>(pub(crate) &'v DeValue<'i>);

impl fmt::Display for Shown<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            DeValue::String(text) if text.len() <= 40 => write!(f, "{:?}", text.as_ref()),
            DeValue::String(_) => f.write_str("a text"),
            DeValue::Integer(digits) => write!(f, "{digits}"),
            DeValue::Float(digits) => write!(f, "{digits}"),
            DeValue::Boolean(is) => write!(f, "{is}"),
            DeValue::Datetime(_) => f.write_str("a date"),
            DeValue::Array(_) => f.write_str("an array"),
            DeValue::Table(_) => f.write_str("a table"),
        }
    }
}
