//! Makes foreign text harmless for a terminal: control characters are written as escapes.

use serde_json::Value;

/// Whether a terminal may interpret the character instead of showing it: control characters,
/// including those that begin escape sequences, and characters that change the direction of text.
fn obeyed(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{061c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}'
                | '\u{feff}'
        )
}

fn written(text: &str, kept: impl Fn(char) -> bool) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if obeyed(c) && !kept(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// Escapes a text that may have several lines.
pub(crate) fn lines(text: &str) -> String {
    written(text, |c| matches!(c, '\n' | '\t'))
}

/// Escapes a text that has to stay on one line.
pub(crate) fn line(text: &str) -> String {
    written(text, |_| false)
}

/// Escapes all texts in a value, including names of members.
pub(crate) fn all(value: &mut Value) {
    match value {
        Value::String(text) if text.contains(obeyed) => *text = lines(text),
        Value::Array(items) => items.iter_mut().for_each(all),
        Value::Object(members) => {
            if members.keys().any(|name| name.contains(obeyed)) {
                *members = std::mem::take(members)
                    .into_iter()
                    .map(|(name, value)| (line(&name), value))
                    .collect();
            }
            members.values_mut().for_each(all);
        }
        _ => {}
    }
}

/// Equivalent JSON, in which texts contain such characters as JSON escapes only.
pub(crate) fn json(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // Outside of texts JSON has no such character but line breaks; within them, serde_json has
        // already escaped those below 0x20.
        if obeyed(c) && c >= '\u{7f}' {
            out.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn nothing_that_a_terminal_obeys_is_left() {
        let evil = "a\x1b[2Jb\x07\u{9b}31m\u{202e}c\x7f\r\u{200b}";
        let shown = lines(evil);
        assert_eq!(shown, "a\\u{1b}[2Jb\\u{7}\\u{9b}31m\\u{202e}c\\u{7f}\\r\\u{200b}");
        assert_eq!(lines("one\n\ttwo é 漢 😀"), "one\n\ttwo é 漢 😀");
        assert_eq!(line("one\ntwo"), "one\\ntwo");
        let mut value = json!({"na\x1bme": ["a\x1b", {"b": "c\u{9b}"}], "n": 1});
        all(&mut value);
        assert_eq!(value, json!({"na\\u{1b}me": ["a\\u{1b}", {"b": "c\\u{9b}"}], "n": 1}));
    }

    #[test]
    fn json_stays_the_same_value() {
        let value = json!({"a\u{9b}": "\x1b\u{202e}\n\u{7f} é 😀"});
        let text = json(&value.to_string());
        assert!(!text.contains(obeyed), "{text}");
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
    }
}
