//! The values of string and character literals.

/// The text of a string literal, quotes included. Only `\"` is unescaped (genom3.md 2.1):
/// other backslash sequences stay as they are.
pub(crate) fn unescape(literal: &str) -> String {
    let body = literal.strip_prefix('"').unwrap_or(literal);
    let mut value = String::with_capacity(body.len());
    let mut chars = body.chars();
    while let Some(c) = chars.next() {
        match c {
            '"' => break,
            '\\' => match chars.next() {
                Some('"') => value.push('"'),
                Some(other) => value.extend(['\\', other]),
                None => value.push('\\'),
            },
            _ => value.push(c),
        }
    }
    value
}

/// The code of a character literal, quotes included; `None` if it is not one byte.
///
/// An intended difference from GenoM3, where a character literal has no type and its value is
/// whatever follows the quote.
pub(crate) fn character(literal: &str) -> Option<u8> {
    let body = literal.strip_prefix('\'')?.strip_suffix('\'')?;
    let Some(escaped) = body.strip_prefix('\\') else {
        let mut chars = body.chars();
        let code = u8::try_from(u32::from(chars.next()?)).ok()?;
        return chars.next().is_none().then_some(code);
    };
    let code = match escaped {
        "n" => b'\n',
        "t" => b'\t',
        "r" => b'\r',
        "a" => 0x07,
        "b" => 0x08,
        "v" => 0x0b,
        "f" => 0x0c,
        "\\" | "'" | "\"" | "?" => *escaped.as_bytes().first()?,
        _ => match escaped.strip_prefix('x') {
            Some(hex) => u8::from_str_radix(hex, 16).ok()?,
            None if escaped.len() <= 3 => u8::from_str_radix(escaped, 8).ok()?,
            None => return None,
        },
    };
    Some(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_quote_is_unescaped_in_strings() {
        assert_eq!(unescape(r#""a\"b\n\\""#), r#"a"b\n\\"#);
        assert_eq!(unescape(r#""foo\\""#), r"foo\\");
    }

    #[test]
    fn character_literals_have_the_value_of_c() {
        let values = ["'x'", "'\\n'", "'\\''", "'\\0'", "'\\x41'", "'\\101'", "'\u{e9}'"];
        let codes = [b'x', b'\n', b'\'', 0, 0x41, 0x41, 0xe9];
        assert_eq!(values.map(character), codes.map(Some));
        assert_eq!(["''", "'ab'", "'\\q'", "'\\777'", "'\u{20ac}'"].map(character), [None; 5]);
    }
}
