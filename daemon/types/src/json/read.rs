//! From JSON into a value in memory. The caller merges into a copy, so that an error half way
//! changes nothing.

use serde_json::{Map, Number, Value};

use crate::graph::{Part, Scalar, Shape};
use crate::json::error::{JsonError, JsonProblem, nearest, shown};
use crate::json::write;
use crate::layout::MAX_NESTING;
use crate::memory::Edit;

/// Bytes by which the sequences of one value may grow in all through indices beyond their ends. It
/// refuses `{"4000000000": 1}`, and a thousand of `{"4000": 1}`.
const MOST_BY_INDEX: usize = 1 << 24;

/// Sets what `json` gives; the rest keeps its value.
pub(crate) fn merge(value: &mut Edit<'_>, json: &Value) -> Result<(), JsonError> {
    let mut reader = Reader { path: String::new(), depth: 0, by_index: MOST_BY_INDEX };
    reader
        .value(value, json)
        .map_err(|problem| JsonError { path: reader.path, problem: Box::new(problem) })
}

struct Reader {
    /// Path of the datum being read; on error it stays at the culprit.
    path: String,
    depth: usize,
    /// Bytes by which sequences may still grow through indices.
    by_index: usize,
}

type Filled = Result<(), JsonProblem>;

impl Reader {
    fn value(&mut self, value: &mut Edit<'_>, json: &Value) -> Filled {
        if self.depth >= MAX_NESTING {
            return Err(JsonProblem::Deep(MAX_NESTING));
        }
        self.depth += 1;
        let node = value.node();
        match &node.shape {
            Shape::Scalar(Scalar::Float | Scalar::Double) => real(value, json)?,
            Shape::Scalar(scalar) => integer(value, *scalar, json)?,
            Shape::Enum { scope, names } => {
                let Value::String(name) = json else {
                    return Err(kind(value, "the name of an enumerator", json));
                };
                let short = name
                    .strip_prefix(&scope.to_string())
                    .and_then(|rest| rest.strip_prefix("::"))
                    .unwrap_or(name);
                let Some(rank) = names.iter().position(|known| known == short) else {
                    let (nearest, known) = nearest(name, names.iter().map(String::as_str));
                    let (ty, name) = (node.name.clone(), name.clone());
                    return Err(JsonProblem::Enumerator { ty, name, nearest, known });
                };
                value.set_integer(rank as i128);
            }
            Shape::Text { bound } => {
                let Value::String(text) = json else { return Err(kind(value, "a string", json)) };
                if text.contains('\0') {
                    return Err(JsonProblem::Nul);
                }
                // The bound counts the NUL (genom3.md 5.2).
                if let Some(most) = bound.map(|bound| bound.saturating_sub(1))
                    && text.len() > most
                {
                    let (ty, found) = (node.name.clone(), text.len());
                    return Err(JsonProblem::TooLong { ty, unit: "bytes", found, most });
                }
                value.set_text(text.as_bytes());
            }
            Shape::Array { length, .. } => match json {
                Value::Array(elements) => {
                    self.room(&node.name, elements.len(), *length)?;
                    self.elements(value, elements)?;
                }
                Value::Object(keyed) => self.keyed(value, keyed, *length, 0)?,
                _ => return Err(kind(value, "an array or an object keyed by index", json)),
            },
            Shape::Sequence { element, bound } => match json {
                Value::Array(elements) => {
                    self.room(&node.name, elements.len(), bound.unwrap_or(u32::MAX as usize))?;
                    if !value.resize(elements.len()) {
                        return Err(JsonProblem::Memory(elements.len()));
                    }
                    self.elements(value, elements)?;
                }
                Value::Object(keyed) => {
                    let size = value.graph().node(*element).layout.size.max(1);
                    let before = value.length();
                    let most = bound.unwrap_or((self.by_index / size).max(before));
                    // The elements of a bounded sequence lie in the value itself: new ones take no
                    // memory.
                    self.keyed(value, keyed, most, if bound.is_some() { 0 } else { size })?;
                }
                _ => return Err(kind(value, "an array or an object keyed by index", json)),
            },
            Shape::Optional { .. } if json.is_null() => value.set_absent(),
            Shape::Optional { .. } => {
                if let Some(mut inner) = value.set_present() {
                    self.value(&mut inner, json)?;
                }
            }
            Shape::Struct { members } => {
                let Value::Object(given) = json else { return Err(kind(value, "an object", json)) };
                for (name, json) in given {
                    let rank = rank(members, name, &node.name)?;
                    if let Some(mut member) = value.member(rank) {
                        self.inside(&mut member, json, |path| push_name(path, name))?;
                    }
                }
            }
            Shape::Union { switch, members, .. } => {
                let Value::Object(given) = json else {
                    return Err(kind(value, "an object {\"d\": .., \"u\": {..}}", json));
                };
                let switch = &value.graph().node(*switch).name;
                self.union(value, switch, members, given)?;
            }
            Shape::Native if json.is_null() => {}
            Shape::Native => return Err(kind(value, "null: only codels know the content", json)),
        }
        self.depth -= 1;
        Ok(())
    }

    /// Reads into a part of the value; restores the path when that succeeds.
    fn inside(
        &mut self,
        value: &mut Edit<'_>,
        json: &Value,
        step: impl FnOnce(&mut String),
    ) -> Filled {
        let length = self.path.len();
        step(&mut self.path);
        self.value(value, json)?;
        self.path.truncate(length);
        Ok(())
    }

    fn room(&self, ty: &str, found: usize, most: usize) -> Filled {
        if found > most {
            let ty = ty.to_owned();
            return Err(JsonProblem::TooLong { ty, unit: "elements", found, most });
        }
        Ok(())
    }

    fn elements(&mut self, value: &mut Edit<'_>, elements: &[Value]) -> Filled {
        for (index, json) in elements.iter().enumerate() {
            if let Some(mut element) = value.element(index) {
                self.inside(&mut element, json, |path| push_index(path, index))?;
            }
        }
        Ok(())
    }

    /// Reads `{"0": .., "3": ..}`; a sequence grows to the greatest index. `size` is the size of an
    /// element in bytes where new ones take memory, otherwise 0.
    fn keyed(
        &mut self,
        value: &mut Edit<'_>,
        keyed: &Map<String, Value>,
        most: usize,
        size: usize,
    ) -> Filled {
        for (key, json) in keyed {
            let index = key.parse().ok().filter(|&index: &usize| index < most);
            let index = index.ok_or_else(|| JsonProblem::Index {
                ty: value.node().name.clone(),
                key: key.clone(),
                last: most.saturating_sub(1),
            })?;
            let more = (index + 1).saturating_sub(value.length());
            if more > 0 {
                let left = self.by_index.checked_sub(more.saturating_mul(size));
                let grown = left.filter(|_| value.resize(index + 1));
                self.by_index = grown.ok_or(JsonProblem::Memory(index + 1))?;
            }
            if let Some(mut element) = value.element(index) {
                self.inside(&mut element, json, |path| push_index(path, index))?;
            }
        }
        Ok(())
    }

    fn union(
        &mut self,
        value: &mut Edit<'_>,
        switch_type: &str,
        members: &[Part],
        given: &Map<String, Value>,
    ) -> Filled {
        let ty = &value.node().name;
        if let Some(name) = given.keys().find(|name| !["d", "u"].contains(&name.as_str())) {
            let (nearest, known) = (None, "d, u".to_owned());
            return Err(JsonProblem::Member { ty: ty.clone(), name: name.clone(), nearest, known });
        }
        if let Some(json) = given.get("d") {
            let length = self.path.len();
            push_name(&mut self.path, "d");
            // Read into a scratch word first: a change of the discriminant empties the union.
            let Shape::Union { switch, .. } = value.node().shape else { return Ok(()) };
            let mut word = 0u64;
            let mut scratch = Edit::scratch(value.graph(), switch, &mut word);
            self.value(&mut scratch, json)?;
            let chosen = scratch.view().integer();
            value.select(chosen);
            self.path.truncate(length);
        }
        let Some(json) = given.get("u") else { return Ok(()) };
        let length = self.path.len();
        push_name(&mut self.path, "u");
        let Value::Object(inner) = json else {
            let expected = format!("{ty}: an object with the selected member");
            return Err(JsonProblem::Kind { expected, found: shown(json) });
        };
        for (name, json) in inner {
            let rank = rank(members, name, ty)?;
            let view = value.view();
            let selected = view.switch().and_then(|d| value.node().shape.selected(d.integer()));
            if selected != Some(rank) {
                let hint = match selected.and_then(|rank| members.get(rank)) {
                    Some(part) => format!("give `{}` or another {switch_type} as \"d\"", part.name),
                    None => format!("give the {switch_type} that selects it as \"d\""),
                };
                let d = view.switch().map_or(Value::Null, write).to_string();
                let (ty, name) = (ty.clone(), name.clone());
                return Err(JsonProblem::Unselected { ty, name, d, hint });
            }
            if let Some(mut member) = value.active() {
                self.inside(&mut member, json, |path| push_name(path, name))?;
            }
        }
        self.path.truncate(length);
        Ok(())
    }
}

fn rank(members: &[Part], name: &str, ty: &str) -> Result<usize, JsonProblem> {
    members.iter().position(|part| part.name == name).ok_or_else(|| {
        let (nearest, known) = nearest(name, members.iter().map(|part| part.name.as_str()));
        JsonProblem::Member { ty: ty.to_owned(), name: name.to_owned(), nearest, known }
    })
}

pub(crate) fn push_name(path: &mut String, name: &str) {
    if !path.is_empty() {
        path.push('.');
    }
    path.push_str(name);
}

pub(crate) fn push_index(path: &mut String, index: usize) {
    path.push_str(&format!("[{index}]"));
}

fn kind(value: &Edit<'_>, looks: &str, json: &Value) -> JsonProblem {
    let expected = format!("{} ({looks})", value.node().name);
    JsonProblem::Kind { expected, found: shown(json) }
}

fn integer(value: &mut Edit<'_>, scalar: Scalar, json: &Value) -> Filled {
    let (looks, min, max) = match scalar {
        Scalar::Boolean => ("true or false", 0, 1),
        Scalar::Char => ("a string of one character", i8::MIN.into(), i8::MAX.into()),
        Scalar::Octet => ("an integer", 0, u8::MAX.into()),
        Scalar::Short => ("an integer", i16::MIN.into(), i16::MAX.into()),
        Scalar::UnsignedShort => ("an integer", 0, u16::MAX.into()),
        Scalar::Long => ("an integer", i32::MIN.into(), i32::MAX.into()),
        Scalar::UnsignedLong => ("an integer", 0, u32::MAX.into()),
        Scalar::LongLong => ("an integer", i64::MIN.into(), i64::MAX.into()),
        _ => ("an integer", 0, i128::from(u64::MAX)),
    };
    let number = match (scalar, json) {
        (Scalar::Boolean, Value::Bool(truth)) => Some(i128::from(*truth)),
        (Scalar::Char, Value::String(text)) => single(text).map(i128::from),
        (_, Value::Number(number)) => whole(number),
        _ => None,
    };
    let number = number.ok_or_else(|| kind(value, looks, json))?;
    if !(min..=max).contains(&number) {
        return Err(JsonProblem::Range {
            ty: value.node().name.clone(),
            found: json.to_string(),
            min: min.to_string(),
            max: max.to_string(),
        });
    }
    value.set_integer(number);
    Ok(())
}

/// The code of a string of one character, as C's signed char.
pub(crate) fn single(text: &str) -> Option<i8> {
    let mut chars = text.chars();
    let code = u8::try_from(chars.next()?).ok()?;
    chars.next().is_none().then_some(code.cast_signed())
}

/// An integer; `2.0` counts as one too, since some encoders write integers so.
pub(crate) fn whole(number: &Number) -> Option<i128> {
    if let Some(number) = number.as_i64() {
        return Some(number.into());
    }
    if let Some(number) = number.as_u64() {
        return Some(number.into());
    }
    let real = number.as_f64()?;
    // Beyond 2^100 it is out of any range anyway, and the message says so.
    (real.fract() == 0.0).then(|| real.clamp(-1e30, 1e30) as i128)
}

fn real(value: &mut Edit<'_>, json: &Value) -> Filled {
    let number = match json {
        Value::Null => Some(f64::NAN),
        Value::Number(number) => number.as_f64(),
        Value::String(text) if text == "inf" => Some(f64::INFINITY),
        Value::String(text) if text == "-inf" => Some(f64::NEG_INFINITY),
        _ => None,
    };
    let number = number.ok_or_else(|| kind(value, "a number, null, \"inf\" or \"-inf\"", json))?;
    let single = matches!(value.node().shape, Shape::Scalar(Scalar::Float));
    if single && number.is_finite() && (number as f32).is_infinite() {
        return Err(JsonProblem::Range {
            ty: value.node().name.clone(),
            found: json.to_string(),
            min: f32::MIN.to_string(),
            max: f32::MAX.to_string(),
        });
    }
    value.set_real(number);
    Ok(())
}
