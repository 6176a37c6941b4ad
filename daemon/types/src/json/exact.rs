//! From a value in memory to JSON that says all of it, for files that are read again by
//! [`convert`](crate::convert).
//!
//! It is what [`write`](super::write) makes, and besides:
//!
//! | IDL | written |
//! |---|---|
//! | string with bytes that are no UTF-8 | `{"base64": "..."}` |
//! | more than 32 octets | `{"base64": "..."}` |
//! | enum out of range | its number |
//! | optional whose value reads as `null` or as an array | in an array: `[null]` is a NaN that is there |
//!
//! A NaN loses its sign and payload. `native` values, and what is nested deeper than
//! [`MAX_NESTING`] sequences, are left out.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use super::read::{push_index, push_name};
use super::write::scalar;
use crate::graph::{Scalar, Shape};
use crate::layout::MAX_NESTING;
use crate::memory::View;

/// Octets up to this number are written as numbers.
const FEW: usize = 32;
/// Most paths that a list has; a last entry counts the others.
const MOST: usize = 100;

/// Key of an object that stands for bytes.
pub(crate) const BASE64: &str = "base64";

/// Places in a value, for reports to users; a limited number of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    listed: Vec<String>,
    more: usize,
}

impl Places {
    pub(crate) fn add(&mut self, place: impl FnOnce() -> String) {
        if self.listed.len() < MOST {
            self.listed.push(place());
        } else {
            self.more += 1;
        }
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// The places, and how many more there are if they are too many.
    #[must_use]
    pub fn listed(&self) -> Vec<String> {
        let more = (self.more > 0).then(|| format!("and {} more", self.more));
        self.listed.iter().cloned().chain(more).collect()
    }
}

/// A value as JSON that says all of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Exact {
    /// The value.
    pub value: Value,
    /// Paths of what cannot be written: `native` values, and what is nested too deep.
    pub left_out: Places,
}

/// The exact JSON of a value.
pub(crate) fn write(value: View<'_>) -> Exact {
    let mut writer = Writer { path: String::new(), left_out: Places::default() };
    let value = writer.at(value, 0);
    Exact { value, left_out: writer.left_out }
}

struct Writer {
    path: String,
    left_out: Places,
}

impl Writer {
    fn at(&mut self, value: View<'_>, depth: usize) -> Value {
        match &value.node().shape {
            Shape::Scalar(_) => scalar(value),
            Shape::Enum { names, .. } => {
                let number = value.integer();
                let name = usize::try_from(number).ok().and_then(|rank| names.get(rank));
                name.map_or_else(|| scalar(value), |name| Value::String(name.clone()))
            }
            Shape::Text { .. } => match std::str::from_utf8(value.text()) {
                Ok(text) => Value::String(text.to_owned()),
                Err(_) => bytes(value.text()),
            },
            Shape::Sequence { .. } if depth >= MAX_NESTING => {
                self.left_out.add(|| self.path.clone());
                Value::Null
            }
            Shape::Array { .. } | Shape::Sequence { .. } => {
                let mut octets = Vec::new();
                for element in value.elements() {
                    if !matches!(element.node().shape, Shape::Scalar(Scalar::Octet)) {
                        break;
                    }
                    octets.push(element.integer() as u8);
                }
                if octets.len() > FEW {
                    return bytes(&octets);
                }
                let depth =
                    depth + usize::from(matches!(value.node().shape, Shape::Sequence { .. }));
                let mut all = Vec::new();
                for (index, element) in value.elements().enumerate() {
                    let step = |path: &mut String| push_index(path, index);
                    all.push(self.inside(element, depth, step));
                }
                Value::Array(all)
            }
            Shape::Optional { .. } => match value.value() {
                None => Value::Null,
                Some(inner) => {
                    let wraps = inner.node().shape.reads_as_null();
                    let inner = self.at(inner, depth);
                    let wrapped = wraps && (inner.is_null() || inner.is_array());
                    if wrapped { Value::Array(vec![inner]) } else { inner }
                }
            },
            Shape::Struct { .. } => {
                let mut all = Map::new();
                for (name, member) in value.members() {
                    let json = self.inside(member, depth, |path| push_name(path, name));
                    if !matches!(member.node().shape, Shape::Native) {
                        all.insert(name.to_owned(), json);
                    }
                }
                Value::Object(all)
            }
            Shape::Union { .. } => {
                let switch = value.switch().map_or(Value::Null, |switch| self.at(switch, depth));
                let mut member = Map::new();
                if let Some((name, active)) = value.active() {
                    let step = |path: &mut String| push_name(path, name);
                    member.insert(name.to_owned(), self.inside(active, depth, step));
                }
                json!({"d": switch, "u": member})
            }
            Shape::Native => {
                self.left_out.add(|| self.path.clone());
                Value::Null
            }
        }
    }

    fn inside(&mut self, value: View<'_>, depth: usize, step: impl FnOnce(&mut String)) -> Value {
        let length = self.path.len();
        step(&mut self.path);
        let json = self.at(value, depth);
        self.path.truncate(length);
        json
    }
}

fn bytes(bytes: &[u8]) -> Value {
    json!({BASE64: STANDARD.encode(bytes)})
}

/// The bytes that an object stands for, if it is one of those.
pub(crate) fn bytes_of(json: &Value) -> Option<Vec<u8>> {
    let object = json.as_object().filter(|object| object.len() == 1)?;
    STANDARD.decode(object.get(BASE64)?.as_str()?).ok()
}
