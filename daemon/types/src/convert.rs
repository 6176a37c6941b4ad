//! Takes values over into a type that may be another one than they were written for, by names of
//! members: for files of another version of a component, and for libraries that are exchanged.
//!
//! What has a place in both is taken over, in whatever order it was declared; what is new keeps the
//! value that it has. Each difference is told.

use serde_json::{Map, Value};

use crate::graph::{Scalar, Shape};
use crate::json::exact::bytes_of;
use crate::json::{Places, push_index, push_name, single, whole};
use crate::layout::MAX_NESTING;
use crate::memory::Edit;
use crate::record::Record;

/// Where a value and a type differ; paths as `goal.x[2]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Conversion {
    /// Members of the type that the value does not have: they keep what they were.
    pub new: Places,
    /// Members of the value that the type does not have.
    pub gone: Places,
    /// What was taken over in another form, as `x: 2.5 is now 3`.
    pub converted: Places,
    /// What cannot be taken over, with the reason: it keeps what it was.
    pub unfit: Places,
}

impl Conversion {
    /// Whether value and type have the same members, and all was taken over as it is.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        [&self.new, &self.gone, &self.converted, &self.unfit].iter().all(|list| list.is_empty())
    }

    /// A line for each difference.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let with = |list: &Places, what: &'static str| {
            list.listed().into_iter().map(move |place| format!("{place}{what}")).collect::<Vec<_>>()
        };
        [
            with(&self.new, " is new"),
            with(&self.gone, " is gone"),
            with(&self.converted, ""),
            with(&self.unfit, ""),
        ]
        .concat()
    }
}

impl Record {
    /// Takes over a value that [`to_exact_json`](Record::to_exact_json) wrote, for this type or for
    /// another one. `native` values stay as they are.
    pub fn take_over(&mut self, json: &Value) -> Conversion {
        let mut taker = Taker { path: String::new(), depth: 0, told: Conversion::default() };
        taker.value(&mut self.edit(), json);
        taker.told
    }

    /// Takes over the value of a record, of the same type or of another one. `native` values stay as
    /// they are.
    pub fn convert_from(&mut self, from: &Record) -> Conversion {
        self.take_over(&from.to_exact_json().value)
    }
}

struct Taker {
    path: String,
    depth: usize,
    told: Conversion,
}

impl Taker {
    fn value(&mut self, value: &mut Edit<'_>, json: &Value) {
        if self.depth >= MAX_NESTING * 2 {
            return self.unfit("nested too deep");
        }
        self.depth += 1;
        self.datum(value, json);
        self.depth -= 1;
    }

    fn datum(&mut self, value: &mut Edit<'_>, json: &Value) {
        let node = value.node();
        match &node.shape {
            Shape::Scalar(Scalar::Float | Scalar::Double) => self.real(value, json),
            Shape::Scalar(scalar) => self.integer(value, *scalar, json),
            Shape::Enum { names, .. } => self.enumerator(value, names, json),
            Shape::Text { bound } => self.text(value, *bound, json),
            Shape::Array { length, .. } => {
                let length = *length;
                self.elements(value, json, |_, wanted| wanted.min(length));
                if let Some(given) = elements_of(json) {
                    (given..length).for_each(|index| self.told(|told| &mut told.new, index));
                }
            }
            Shape::Sequence { bound, .. } => {
                let bound = *bound;
                self.elements(value, json, |value, wanted| {
                    let wanted = bound.map_or(wanted, |bound| wanted.min(bound));
                    if value.resize(wanted) { wanted } else { 0 }
                });
            }
            Shape::Optional { element } => {
                let wraps = value.graph().node(*element).shape.reads_as_null();
                let inner = match json {
                    Value::Array(one) if wraps && one.len() == 1 => &one[0],
                    Value::Null => return value.set_absent(),
                    other => other,
                };
                if let Some(mut present) = value.set_present() {
                    self.value(&mut present, inner);
                }
            }
            Shape::Struct { members } => {
                let Value::Object(given) = json else { return self.kind("a struct", json) };
                for (rank, part) in members.iter().enumerate() {
                    let Some(mut member) = value.member(rank) else { continue };
                    match given.get(&part.name) {
                        Some(json) => {
                            self.inside(&mut member, json, |path| push_name(path, &part.name))
                        }
                        None if matches!(member.node().shape, Shape::Native) => {}
                        None => self.named(|told| &mut told.new, &part.name),
                    }
                }
                let known = |name: &String| members.iter().any(|part| part.name == *name);
                for name in given.keys().filter(|name| !known(name)) {
                    self.named(|told| &mut told.gone, name);
                }
            }
            Shape::Union { switch, .. } => {
                let Value::Object(given) = json else { return self.kind("a union", json) };
                let switch = *switch;
                self.union(value, switch, given);
            }
            Shape::Native => {}
        }
    }

    fn inside(&mut self, value: &mut Edit<'_>, json: &Value, step: impl FnOnce(&mut String)) {
        let length = self.path.len();
        step(&mut self.path);
        self.value(value, json);
        self.path.truncate(length);
    }

    /// Elements of an array or a sequence; `room` makes room for so many, and returns for how many
    /// there is.
    fn elements(
        &mut self,
        value: &mut Edit<'_>,
        json: &Value,
        room: impl FnOnce(&mut Edit<'_>, usize) -> usize,
    ) {
        let bytes = bytes_of(json);
        let Some(given) = elements_of(json) else { return self.kind("a list", json) };
        let room = room(value, given);
        for index in 0..room {
            let Some(mut element) = value.element(index) else { continue };
            match (&bytes, json) {
                (Some(bytes), _) => {
                    let byte = Value::from(bytes[index]);
                    self.inside(&mut element, &byte, |path| push_index(path, index));
                }
                (None, Value::Array(all)) => {
                    self.inside(&mut element, &all[index], |path| push_index(path, index));
                }
                _ => {}
            }
        }
        if room < given {
            let path = self.shown();
            self.told.converted.add(|| format!("{path}: {given} elements are now {room}"));
        }
    }

    fn union(
        &mut self,
        value: &mut Edit<'_>,
        switch: crate::graph::Ix,
        given: &Map<String, Value>,
    ) {
        let mut word = 0_u64;
        let mut scratch = Edit::scratch(value.graph(), switch, &mut word);
        let before = self.told.clone();
        self.inside(&mut scratch, given.get("d").unwrap_or(&Value::Null), |path| {
            push_name(path, "d")
        });
        if self.told.unfit != before.unfit {
            return;
        }
        value.select(scratch.view().integer());
        let none = Map::new();
        let given = given.get("u").and_then(Value::as_object).unwrap_or(&none);
        let active = value.view().active().map(|(name, _)| name.to_owned());
        for (name, json) in given {
            if Some(name) == active.as_ref() {
                if let Some(mut member) = value.active() {
                    self.inside(&mut member, json, |path| push_name(path, name));
                }
            } else {
                self.named(|told| &mut told.gone, name);
            }
        }
        if let Some(name) = active.filter(|name| !given.contains_key(name)) {
            self.named(|told| &mut told.new, &name);
        }
    }

    fn integer(&mut self, value: &mut Edit<'_>, scalar: Scalar, json: &Value) {
        let (min, max): (i128, i128) = match scalar {
            Scalar::Boolean => (0, 1),
            Scalar::Char => (i8::MIN.into(), i8::MAX.into()),
            Scalar::Octet => (0, u8::MAX.into()),
            Scalar::Short => (i16::MIN.into(), i16::MAX.into()),
            Scalar::UnsignedShort => (0, u16::MAX.into()),
            Scalar::Long => (i32::MIN.into(), i32::MAX.into()),
            Scalar::UnsignedLong => (0, u32::MAX.into()),
            Scalar::LongLong => (i64::MIN.into(), i64::MAX.into()),
            _ => (0, u64::MAX.into()),
        };
        let (number, same) = match json {
            Value::Bool(truth) => (i128::from(*truth), scalar == Scalar::Boolean),
            Value::Number(number) => match (whole(number), number.as_f64()) {
                (Some(number), _) => (number, scalar != Scalar::Boolean),
                (None, Some(real)) => (real.round().clamp(-1e30, 1e30) as i128, false),
                (None, None) => return self.kind("a number", json),
            },
            Value::String(text) if scalar == Scalar::Char => match single(text) {
                Some(code) => (code.into(), true),
                None => return self.kind("one character", json),
            },
            _ => return self.kind("a number", json),
        };
        if !(min..=max).contains(&number) {
            return self.unfit(&format!("{json} is not between {min} and {max}"));
        }
        value.set_integer(number);
        if !same {
            let path = self.shown();
            self.told.converted.add(|| format!("{path}: {json} is now {number}"));
        }
    }

    fn real(&mut self, value: &mut Edit<'_>, json: &Value) {
        let number = match json {
            Value::Null => f64::NAN,
            Value::String(text) if text == "inf" => f64::INFINITY,
            Value::String(text) if text == "-inf" => f64::NEG_INFINITY,
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
            Value::Bool(truth) => {
                let path = self.shown();
                self.told.converted.add(|| format!("{path}: {json} is a number now"));
                f64::from(u8::from(*truth))
            }
            _ => return self.kind("a number", json),
        };
        let single = matches!(value.node().shape, Shape::Scalar(Scalar::Float));
        if single && number.is_finite() && (number as f32).is_infinite() {
            return self.unfit(&format!("{json} is too large for a float"));
        }
        value.set_real(number);
    }

    fn enumerator(&mut self, value: &mut Edit<'_>, names: &[String], json: &Value) {
        let number = match json {
            Value::String(name) => {
                names.iter().position(|known| known == name).map(|at| at as i128)
            }
            // Memory of codels held no enumerator.
            Value::Number(number) => {
                whole(number).filter(|number| (0..=i128::from(u32::MAX)).contains(number))
            }
            _ => None,
        };
        match number {
            Some(number) => value.set_integer(number),
            None => self.unfit(&format!("{} is none of {}", shown(json), names.join(", "))),
        }
    }

    fn text(&mut self, value: &mut Edit<'_>, bound: Option<usize>, json: &Value) {
        let bytes = bytes_of(json);
        let mut text = match (json, &bytes) {
            (_, Some(bytes)) => bytes.as_slice(),
            (Value::String(text), None) => text.as_bytes(),
            _ => return self.kind("a string", json),
        };
        if text.contains(&0) {
            return self.unfit("it holds a NUL character, which ends strings in C");
        }
        // The bound counts the NUL (genom3.md 5.2).
        if let Some(most) = bound.map(|bound| bound.saturating_sub(1))
            && text.len() > most
        {
            let mut end = most;
            // Not within a character.
            while end > 0 && text[end] & 0xc0 == 0x80 {
                end -= 1;
            }
            text = &text[..end];
            let path = self.shown();
            self.told.converted.add(|| format!("{path}: cut to {end} bytes"));
        }
        value.set_text(text);
    }

    fn shown(&self) -> String {
        if self.path.is_empty() { "the value".to_owned() } else { self.path.clone() }
    }

    fn unfit(&mut self, why: &str) {
        let path = self.shown();
        self.told.unfit.add(|| format!("{path}: {why}"));
    }

    fn kind(&mut self, wanted: &str, json: &Value) {
        self.unfit(&format!("{} is not {wanted}", shown(json)));
    }

    fn named(&mut self, list: impl FnOnce(&mut Conversion) -> &mut Places, name: &str) {
        let mut path = self.path.clone();
        push_name(&mut path, name);
        list(&mut self.told).add(|| path);
    }

    fn told(&mut self, list: impl FnOnce(&mut Conversion) -> &mut Places, index: usize) {
        let mut path = self.path.clone();
        push_index(&mut path, index);
        list(&mut self.told).add(|| path);
    }
}

/// Number of elements, if it is a list.
fn elements_of(json: &Value) -> Option<usize> {
    match json {
        Value::Array(all) => Some(all.len()),
        other => bytes_of(other).map(|bytes| bytes.len()),
    }
}

/// A value, shortened.
fn shown(json: &Value) -> String {
    match json {
        Value::Array(all) => format!("a list of {}", all.len()),
        Value::Object(_) => "an object".to_owned(),
        Value::String(text) if text.chars().count() > 40 => {
            format!("{:?}...", text.chars().take(40).collect::<String>())
        }
        other => other.to_string(),
    }
}
