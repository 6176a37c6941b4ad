//! Bottles as text, as people type them and as the text carriers send them:
//! `goto 0.5 "to the left" (1 2 3) [ok] {1 2}`.

use super::value::{letters, word_of};
use super::{MOST_DEPTH, Value};

/// The text is no bottle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NoText {
    #[error("a `{0}` is missing")]
    Open(char),
    #[error("a `{0}` has no beginning")]
    Close(char),
    #[error("[...] holds at most four letters")]
    Vocab,
    #[error("{{...}} holds numbers from 0 to 255")]
    Blob,
    #[error("it has lists within lists, {MOST_DEPTH} deep")]
    Deep,
}

impl Value {
    /// The values of a bottle in text.
    pub(crate) fn parse(text: &str) -> Result<Vec<Self>, NoText> {
        let mut parser = Parser { rest: text, depth: 0 };
        let values = parser.list()?;
        match parser.rest.chars().next() {
            None => Ok(values),
            Some(close) => Err(NoText::Close(close)),
        }
    }

    /// These values as a line of text.
    pub(crate) fn line(values: &[Self]) -> String {
        let mut line = String::new();
        for (index, value) in values.iter().enumerate() {
            if index > 0 {
                line.push(' ');
            }
            write(value, &mut line);
        }
        line
    }
}

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Values until a closing parenthesis or the end.
    fn list(&mut self) -> Result<Vec<Value>, NoText> {
        let mut values = Vec::new();
        loop {
            self.rest = self.rest.trim_start_matches([' ', '\t', '\r', '\n']);
            let Some(first) = self.rest.chars().next() else { return Ok(values) };
            values.push(match first {
                ')' => return Ok(values),
                ']' | '}' => return Err(NoText::Close(first)),
                '(' => {
                    self.skip(1);
                    self.depth += 1;
                    if self.depth >= MOST_DEPTH {
                        return Err(NoText::Deep);
                    }
                    let inner = self.list()?;
                    self.rest = self.rest.strip_prefix(')').ok_or(NoText::Open(')'))?;
                    self.depth -= 1;
                    Value::List(inner)
                }
                '"' => {
                    self.skip(1);
                    Value::Text(self.quoted()?)
                }
                '[' => Value::Vocab(word_of(self.until(']')?).ok_or(NoText::Vocab)?),
                '{' => {
                    let numbers = self.until('}')?.split_ascii_whitespace();
                    let bytes: Result<_, _> = numbers.map(str::parse).collect();
                    Value::Blob(bytes.map_err(|_| NoText::Blob)?)
                }
                _ => self.word(),
            });
        }
    }

    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or_default();
    }

    /// What is between the first character and `close`.
    fn until(&mut self, close: char) -> Result<&'a str, NoText> {
        let inside = self.rest.get(1..).unwrap_or_default();
        let (taken, rest) = inside.split_once(close).ok_or(NoText::Open(close))?;
        self.rest = rest;
        Ok(taken)
    }

    fn quoted(&mut self) -> Result<String, NoText> {
        let mut text = String::new();
        let mut escaped = false;
        for (at, one) in self.rest.char_indices() {
            match one {
                _ if escaped => {
                    escaped = false;
                    text.push(match one {
                        'n' => '\n',
                        'r' => '\r',
                        't' => '\t',
                        other => other,
                    });
                }
                '\\' => escaped = true,
                '"' => {
                    self.skip(at + 1);
                    return Ok(text);
                }
                other => text.push(other),
            }
        }
        Err(NoText::Open('"'))
    }

    fn word(&mut self) -> Value {
        let end = self.rest.find([' ', '\t', '\r', '\n', '(', ')', '"']);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        let numeric = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        match word {
            "true" => Value::Vocab(u32::from(b'1')),
            "false" => Value::Vocab(0),
            _ if !numeric => Value::from(word),
            _ => match (word.parse(), word.parse()) {
                (Ok(int), _) => Value::Int(int),
                (_, Ok(float)) => Value::Float(float),
                _ => Value::from(word),
            },
        }
    }
}

fn write(value: &Value, line: &mut String) {
    match value {
        Value::Int(value) => line.push_str(&value.to_string()),
        Value::Float(value) => line.push_str(&format!("{value:?}")),
        Value::Vocab(word) => line.push_str(&format!("[{}]", letters(*word))),
        Value::Text(text) => write_text(text, line),
        Value::Blob(bytes) => {
            let bytes: Vec<String> = bytes.iter().map(u8::to_string).collect();
            line.push_str(&format!("{{{}}}", bytes.join(" ")));
        }
        Value::List(values) => line.push_str(&format!("({})", Value::line(values))),
    }
}

fn write_text(text: &str, line: &mut String) {
    let is_word = matches!(Value::parse(text).as_deref(), Ok([Value::Text(word)]) if word == text);
    if is_word && !text.contains(['"', '\\', '{', '[']) {
        return line.push_str(text);
    }
    line.push('"');
    for one in text.chars() {
        match one {
            '\n' => line.push_str("\\n"),
            '\r' => line.push_str("\\r"),
            '"' | '\\' => line.extend(['\\', one]),
            other => line.push(other),
        }
    }
    line.push('"');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_what_people_type_and_comes_back_as_it_was() {
        let text = r#"1 2.5 hello (1 (2 "a b") ()) [ok] {1 2 3} -4 "say \"hi\"\r\n" "5" @start"#;
        let values = Value::parse(text).unwrap();
        assert_eq!(Value::line(&values), text);
        assert_eq!(values.len(), 10);
        assert_eq!(Value::read(&Value::to_bottle(&values)).unwrap(), values);
        assert_eq!(Value::parse("").unwrap(), []);
        assert_eq!(Value::parse("true false").unwrap(), [Value::Vocab(49), Value::Vocab(0)]);
    }

    #[test]
    fn text_that_is_no_bottle_is_refused_with_the_reason() {
        for (text, why) in [
            ("(1 2", NoText::Open(')')),
            ("1)", NoText::Close(')')),
            ("\"open", NoText::Open('"')),
            ("[toolong]", NoText::Vocab),
            ("{1 256}", NoText::Blob),
            ("{1", NoText::Open('}')),
        ] {
            assert_eq!(Value::parse(text), Err(why), "{text}");
        }
        assert_eq!(Value::parse(&"(".repeat(1000)), Err(NoText::Deep));
    }
}
