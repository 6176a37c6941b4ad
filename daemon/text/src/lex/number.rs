//! Splits a preprocessing number into literals and what follows them directly (genom3.md 2.1).
//!
//! `5ms` is 5 and `ms`, `0x1Fu` one integer, `1.5d` a fixed point literal.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::Span;
use crate::token::TokenKind;

/// The tokens of a preprocessing number, each with its position.
pub(super) fn cut(text: &str, span: Span, diagnostics: &mut Diagnostics) -> Vec<(TokenKind, Span)> {
    // In a macro's expansion or across a joined line, offsets inside the token are not known.
    let exact = (span.end - span.start) as usize == text.len();
    let place = |start: usize, end: usize| {
        let at = |offset: usize| span.start + u32::try_from(offset).unwrap_or(0);
        if exact { Span { start: at(start), end: at(end), ..span } } else { span }
    };
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        let bytes = rest.as_bytes();
        let starts_number = bytes[0].is_ascii_digit()
            || bytes[0] == b'.' && bytes.get(1).is_some_and(u8::is_ascii_digit);
        let (kind, length) = if starts_number {
            let here = |length| place(at, at + length);
            literal(rest, here, diagnostics)
        } else if bytes[0].is_ascii_alphabetic() || bytes[0] == b'_' {
            let length = run(bytes, |byte| byte.is_ascii_alphanumeric() || byte == b'_');
            (TokenKind::Identifier(rest[..length].into()), length)
        } else {
            // `.`, `+` or `-`: nothing else is part of a preprocessing number.
            let sign = match bytes[0] {
                b'+' => "+",
                b'-' => "-",
                _ => ".",
            };
            (TokenKind::Punctuation(sign), 1)
        };
        tokens.push((kind, place(at, at + length)));
        at += length;
    }
    tokens
}

/// The literal at the beginning of `rest` and its length.
fn literal(
    rest: &str,
    place: impl Fn(usize) -> Span,
    diagnostics: &mut Diagnostics,
) -> (TokenKind, usize) {
    let bytes = rest.as_bytes();
    if let [b'0', b'x' | b'X', digit, ..] = bytes
        && digit.is_ascii_hexdigit()
    {
        let digits = 2 + run(&bytes[2..], |byte| byte.is_ascii_hexdigit());
        let length = digits + integer_suffix(rest, digits, &place, diagnostics);
        return (integer(&rest[2..digits], 16, place(length), diagnostics), length);
    }
    let whole = run(bytes, |byte| byte.is_ascii_digit());
    let mut length = whole;
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        length += run(&bytes[length..], |byte| byte.is_ascii_digit());
    }
    length += exponent(&bytes[length..]);
    if length > whole {
        // Rust's `parse` accepts what C allows: `1.`, `.5`, `1e-3`.
        let value = rest[..length].parse().unwrap_or(f64::INFINITY);
        if value == f64::INFINITY {
            let message = format!("`{}` is too large for a double", &rest[..length]);
            diagnostics.push(Diagnostic::error("E0116", place(length), message));
        }
        return match bytes.get(length) {
            Some(b'f' | b'F' | b'l' | b'L') => (TokenKind::Float(value), length + 1),
            Some(b'd' | b'D') => (TokenKind::Fixed, length + 1),
            _ => (TokenKind::Float(value), length),
        };
    }
    if matches!(bytes.get(whole), Some(b'd' | b'D')) {
        return (TokenKind::Fixed, whole + 1);
    }
    let length = whole + integer_suffix(rest, whole, &place, diagnostics);
    let digits = &rest[..whole];
    if digits.len() > 1 && digits.starts_with('0') {
        if let Some(bad) = digits.find(['8', '9']) {
            let message = format!("`{}` is no digit of an octal number", &digits[bad..=bad]);
            diagnostics.push(
                Diagnostic::error("E0116", place(length), message)
                    .help("a number that begins with 0 is octal: remove the zeros before it"),
            );
            return (integer(digits, 10, place(length), diagnostics), length);
        }
        return (integer(digits, 8, place(length), diagnostics), length);
    }
    (integer(digits, 10, place(length), diagnostics), length)
}

/// An intended difference from GenoM3: integers have 64 bits, and larger ones are an error.
fn integer(digits: &str, radix: u32, span: Span, diagnostics: &mut Diagnostics) -> TokenKind {
    let value = u64::from_str_radix(digits, radix);
    if value.is_err() {
        let message = "this integer does not fit in 64 bits";
        diagnostics.push(
            Diagnostic::error("E0116", span, message)
                .help(format!("the largest integer is {}", u64::MAX)),
        );
    }
    TokenKind::Integer(value.unwrap_or(u64::MAX))
}

/// Length of `u`, `l` or a pair of them after the digits.
///
/// An intended difference: GenoM3 reads `5us` as suffix `u` and five seconds.
fn integer_suffix(
    rest: &str,
    digits: usize,
    place: &impl Fn(usize) -> Span,
    diagnostics: &mut Diagnostics,
) -> usize {
    let after = &rest[digits..];
    if after == "us" {
        let message = format!("`{rest}` is read as {} microseconds", &rest[..digits]);
        diagnostics.push(
            Diagnostic::warning("W0101", place(rest.len()), message)
                .label(format!("GenoM3 2.99 reads {} s here", &rest[..digits]))
                .help(format!("write `{} us` for the same meaning everywhere", &rest[..digits])),
        );
        return 0;
    }
    match after.as_bytes() {
        [b'u' | b'U', b'l' | b'L', ..] | [b'l' | b'L', b'u' | b'U', ..] => 2,
        [b'u' | b'U' | b'l' | b'L', ..] => 1,
        _ => 0,
    }
}

/// Length of an exponent; 0 when no digit follows the `e`.
fn exponent(bytes: &[u8]) -> usize {
    let sign = match bytes {
        [b'e' | b'E', b'+' | b'-', ..] => 2,
        [b'e' | b'E', ..] => 1,
        _ => return 0,
    };
    match run(&bytes[sign..], |byte| byte.is_ascii_digit()) {
        0 => 0,
        digits => sign + digits,
    }
}

fn run(bytes: &[u8], accepts: impl Fn(u8) -> bool) -> usize {
    bytes.iter().take_while(|byte| accepts(**byte)).count()
}
