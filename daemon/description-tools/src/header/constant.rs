//! Constants in C (genom3.md 5.2).

use genom_description::model::Constant;
use genom_types::{Kind, ScopedName, TypeId, TypeTable};
use serde_json::Value;

use super::declare::declare;
use super::guard::guarded;
use super::types::enumerator;

/// `static const T name = value;` under its own guard.
pub(super) fn define(out: &mut String, types: &TypeTable, constant: &Constant) {
    let name = constant.name.to_c();
    let declared = match types.resolved(constant.ty) {
        // A constant pointer, so that an unused one causes no warning.
        Kind::String { bound: None } => format!("char *const {name}"),
        _ => declare(types, constant.ty, &name),
    };
    let value = value_in(types, constant.ty, &constant.value, &enumerator);
    guarded(out, &name, &format!("static const {declared} = {value};"));
}

/// A value as a C expression of its type; one out of range is truncated as by a cast. `enumerator`
/// gives the C names of enumerators.
pub(super) fn value_in(
    types: &TypeTable,
    ty: TypeId,
    value: &Value,
    enumerator: &dyn Fn(&ScopedName, &str) -> String,
) -> String {
    let integer = || {
        let signed = value.as_i64().map(i128::from);
        signed.or(value.as_u64().map(i128::from)).unwrap_or_default()
    };
    // GenoM3 accepts constants out of range (genom3.md 2.6): the low bits remain.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    match types.resolved(ty) {
        Kind::Boolean => {
            let set = value.as_bool().unwrap_or_else(|| integer() != 0);
            if set { "true".to_owned() } else { "false".to_owned() }
        }
        Kind::Char => match value.as_str() {
            Some(text) => (text.bytes().next().unwrap_or(0) as i8).to_string(),
            None => (integer() as i8).to_string(),
        },
        Kind::Octet => (integer() as u8).to_string(),
        Kind::Short => (integer() as i16).to_string(),
        Kind::UnsignedShort => (integer() as u16).to_string(),
        Kind::Long => (integer() as i32).to_string(),
        Kind::UnsignedLong => format!("{}U", integer() as u32),
        Kind::LongLong => match integer() as i64 {
            i64::MIN => "(-9223372036854775807LL - 1)".to_owned(),
            number => format!("{number}LL"),
        },
        Kind::UnsignedLongLong => format!("{}ULL", integer() as u64),
        Kind::Float | Kind::Double => format!("{:?}", value.as_f64().unwrap_or_default()),
        Kind::Enum { name, enumerators } => match value.as_str() {
            Some(short) => enumerator(name, short.rsplit("::").next().unwrap_or(short)),
            None => {
                let rank = usize::try_from(integer()).unwrap_or_default();
                enumerators.get(rank).map_or_else(|| rank.to_string(), |e| enumerator(name, e))
            }
        },
        Kind::String { bound } => {
            let text = value.as_str().unwrap_or_default();
            let room = bound.map_or(usize::MAX, |bound| (bound as usize).saturating_sub(1));
            let mut cut = text.len().min(room);
            while !text.is_char_boundary(cut) {
                cut -= 1;
            }
            literal(text.get(..cut).unwrap_or_default())
        }
        _ => value.to_string(),
    }
}

/// A C string literal. Backslash sequences were kept as written (genom3.md 2.1): those that C knows
/// stay, other backslashes are escaped.
pub(super) fn literal(text: &str) -> String {
    let mut out = String::from("\"");
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' => out.push_str("\\\""),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\\' => match chars.peek() {
                Some('a' | 'b' | 'f' | 'n' | 'r' | 't' | 'v' | '\\' | '\'' | '0'..='7') => {
                    out.push('\\');
                    out.extend(chars.next());
                }
                _ => out.push_str("\\\\"),
            },
            // `??=` and the like would be trigraphs.
            '?' => out.push_str("\\?"),
            _ => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::literal;

    #[test]
    fn escapes_of_c_stay_and_others_are_doubled() {
        assert_eq!(literal("a\"b\\n\\q\\\\ ?\n\\"), r#""a\"b\n\\q\\ \?\n\\""#);
    }
}
