//! Values of ROS parameters: their encoding, and their conversion from and to IDL types.

use genom_types::{DataType, Kind};
use serde_json::{Map, Number, Value as Json};

use super::error::SetError;
use crate::body::{self, Fields};

/// Greatest depth of nested structs with one member each that are followed.
const DEEPEST: usize = 8;

/// `rcl_interfaces/msg/ParameterValue`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Value {
    #[default]
    NotSet,
    Bool(bool),
    Integer(i64),
    Double(f64),
    Text(String),
    Bytes(Vec<u8>),
    Bools(Vec<bool>),
    Integers(Vec<i64>),
    Doubles(Vec<f64>),
    Texts(Vec<String>),
}

/// `rcl_interfaces/msg/ParameterType`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Type {
    NotSet = 0,
    Bool = 1,
    Integer = 2,
    Double = 3,
    Text = 4,
    Bytes = 5,
    Bools = 6,
    Integers = 7,
    Doubles = 8,
    Texts = 9,
}

impl Type {
    /// Name in ROS.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::NotSet => "not set",
            Self::Bool => "bool",
            Self::Integer => "integer",
            Self::Double => "double",
            Self::Text => "string",
            Self::Bytes => "byte array",
            Self::Bools => "bool array",
            Self::Integers => "integer array",
            Self::Doubles => "double array",
            Self::Texts => "string array",
        }
    }
}

impl Value {
    pub(crate) fn ty(&self) -> Type {
        match self {
            Self::NotSet => Type::NotSet,
            Self::Bool(_) => Type::Bool,
            Self::Integer(_) => Type::Integer,
            Self::Double(_) => Type::Double,
            Self::Text(_) => Type::Text,
            Self::Bytes(_) => Type::Bytes,
            Self::Bools(_) => Type::Bools,
            Self::Integers(_) => Type::Integers,
            Self::Doubles(_) => Type::Doubles,
            Self::Texts(_) => Type::Texts,
        }
    }

    /// Appends it to a payload whose alignment starts at 0. All fields are encoded, whatever the
    /// type.
    pub(crate) fn put(&self, out: &mut Vec<u8>) {
        out.push(self.ty() as u8);
        out.push(u8::from(matches!(self, Self::Bool(true))));
        put_long(out, if let Self::Integer(value) = self { *value } else { 0 });
        put_double(out, if let Self::Double(value) = self { *value } else { 0.0 });
        body::put_string(out, if let Self::Text(text) = self { text } else { "" });
        let bytes: &[u8] = if let Self::Bytes(bytes) = self { bytes } else { &[] };
        put_all(out, bytes, |out, byte| out.push(*byte));
        let bools: &[bool] = if let Self::Bools(bools) = self { bools } else { &[] };
        put_all(out, bools, |out, value| out.push(u8::from(*value)));
        let integers: &[i64] = if let Self::Integers(all) = self { all } else { &[] };
        put_all(out, integers, |out, value| put_long(out, *value));
        let doubles: &[f64] = if let Self::Doubles(all) = self { all } else { &[] };
        put_all(out, doubles, |out, value| put_double(out, *value));
        let texts: &[String] = if let Self::Texts(all) = self { all } else { &[] };
        put_all(out, texts, |out, text| body::put_string(out, text));
    }

    /// Reads a value; `None` if it is truncated or of an unknown type.
    pub(crate) fn take(fields: &mut Fields<'_>) -> Option<Self> {
        let ty = fields.byte()?;
        let bool = Self::Bool(fields.byte()? != 0);
        let integer = Self::Integer(fields.long()?.cast_signed());
        let double = Self::Double(f64::from_bits(fields.long()?));
        let text = Self::Text(fields.string()?.to_owned());
        let bytes = Self::Bytes(fields.all(Fields::byte)?);
        let bools = Self::Bools(fields.all(|fields| Some(fields.byte()? != 0))?);
        let integers = Self::Integers(fields.all(|fields| Some(fields.long()?.cast_signed()))?);
        let doubles = Self::Doubles(fields.all(|fields| Some(f64::from_bits(fields.long()?)))?);
        let texts = Self::Texts(fields.all(|fields| fields.string().map(str::to_owned))?);
        let all = [bool, integer, double, text, bytes, bools, integers, doubles, texts];
        match ty {
            0 => Some(Self::NotSet),
            _ => all.into_iter().find(|value| value.ty() as u8 == ty),
        }
    }

    fn to_json(&self) -> Json {
        let double = |value: &f64| match *value {
            f64::INFINITY => Json::from("inf"),
            f64::NEG_INFINITY => Json::from("-inf"),
            // JSON has no NaN: it becomes null.
            value => Number::from_f64(value).map_or(Json::Null, Json::Number),
        };
        match self {
            Self::NotSet => Json::Null,
            Self::Bool(value) => (*value).into(),
            Self::Integer(value) => (*value).into(),
            Self::Double(value) => double(value),
            Self::Text(text) => text.as_str().into(),
            Self::Bytes(bytes) => bytes.as_slice().into(),
            Self::Bools(all) => all.as_slice().into(),
            Self::Integers(all) => all.as_slice().into(),
            Self::Doubles(all) => all.iter().map(double).collect(),
            Self::Texts(all) => all.as_slice().into(),
        }
    }

    fn from_json(ty: Type, json: &Json) -> Option<Self> {
        fn each<T>(json: &Json, one: impl Fn(&Json) -> Option<T>) -> Option<Vec<T>> {
            json.as_array()?.iter().map(one).collect()
        }
        let double = |json: &Json| match json {
            Json::Null => Some(f64::NAN),
            Json::String(text) => text.parse().ok(),
            _ => json.as_f64(),
        };
        let text = |json: &Json| json.as_str().map(str::to_owned);
        let byte = |json: &Json| json.as_u64().and_then(|byte| u8::try_from(byte).ok());
        Some(match ty {
            Type::NotSet => Self::NotSet,
            Type::Bool => Self::Bool(json.as_bool()?),
            Type::Integer => Self::Integer(json.as_i64()?),
            Type::Double => Self::Double(double(json)?),
            Type::Text => Self::Text(text(json)?),
            Type::Bytes => Self::Bytes(each(json, byte)?),
            Type::Bools => Self::Bools(each(json, Json::as_bool)?),
            Type::Integers => Self::Integers(each(json, Json::as_i64)?),
            Type::Doubles => Self::Doubles(each(json, double)?),
            Type::Texts => Self::Texts(each(json, text)?),
        })
    }
}

pub(crate) fn put_word(out: &mut Vec<u8>, value: u32) {
    out.resize(out.len().next_multiple_of(4), 0);
    out.extend_from_slice(&value.to_le_bytes());
}

pub(crate) fn put_long(out: &mut Vec<u8>, value: i64) {
    out.resize(out.len().next_multiple_of(8), 0);
    out.extend_from_slice(&value.to_le_bytes());
}

fn put_double(out: &mut Vec<u8>, value: f64) {
    put_long(out, value.to_bits().cast_signed());
}

/// Appends a sequence.
pub(crate) fn put_all<T>(out: &mut Vec<u8>, all: &[T], mut put: impl FnMut(&mut Vec<u8>, &T)) {
    put_word(out, u32::try_from(all.len()).unwrap_or(u32::MAX));
    all.iter().for_each(|one| put(out, one));
}

/// An IDL struct with one member, which a parameter can represent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Path to the value: the only member, the only member of that, and so on.
    path: Vec<String>,
    pub(crate) ty: Type,
    /// Least and greatest value of an integer.
    pub(crate) range: Option<(i64, i64)>,
    /// Further restrictions of the value, in words.
    pub(crate) constraint: String,
    /// Number of elements of an array, all of which must be given.
    length: Option<usize>,
}

impl Shape {
    /// How a parameter represents the struct; `None` if it cannot.
    pub(crate) fn of(ty: &DataType) -> Option<Self> {
        let (mut ty, mut path) = (ty.clone(), Vec::new());
        while matches!(ty.kind(), Kind::Struct { .. }) && path.len() < DEEPEST {
            let (1, Some(member), Some(name)) =
                (ty.member_count(), ty.member(0), ty.member_name(0))
            else {
                return None;
            };
            path.push(name.to_owned());
            ty = member;
        }
        if path.is_empty() {
            return None;
        }
        let plain = |ty, range| Self {
            path: path.clone(),
            ty,
            range,
            constraint: String::new(),
            length: None,
        };
        let length = match ty.kind() {
            Kind::Array { length, .. } => Some(usize::try_from(*length).ok()?),
            Kind::Sequence { .. } => None,
            _ => {
                let (ty, range, constraint) = scalar(&ty)?;
                return Some(Self { constraint, ..plain(ty, range) });
            }
        };
        let element = ty.element()?;
        let (of, range, choices) = scalar(&element)?;
        let ty = match of {
            Type::Bool => Type::Bools,
            Type::Integer if matches!(element.kind(), Kind::Octet) => Type::Bytes,
            Type::Integer => Type::Integers,
            Type::Double => Type::Doubles,
            _ => Type::Texts,
        };
        let count = length.map(|length| format!("{length} elements"));
        let constraint = [count.unwrap_or_default(), choices];
        let constraint: Vec<_> = constraint.into_iter().filter(|part| !part.is_empty()).collect();
        Some(Self { constraint: constraint.join(", each "), length, ..plain(ty, range) })
    }

    /// Name of the member.
    pub(crate) fn name(&self) -> &str {
        self.path.first().map_or("", String::as_str)
    }

    /// The struct as JSON, from the parameter's value.
    pub(crate) fn json(&self, value: &Value) -> Result<Json, SetError> {
        if value.ty() != self.ty {
            return Err(SetError::Type { wanted: self.ty.name(), given: value.ty().name() });
        }
        let json = value.to_json();
        if let (Some(wanted), Some(given)) = (self.length, json.as_array().map(Vec::len))
            && wanted != given
        {
            return Err(SetError::Length { wanted, given });
        }
        let within = |json, name: &String| Json::Object(Map::from_iter([(name.clone(), json)]));
        Ok(self.path.iter().rev().fold(json, within))
    }

    /// The parameter's value, from the struct as JSON.
    pub(crate) fn value(&self, json: &Json) -> Option<Value> {
        let json = self.path.iter().try_fold(json, |json, name| json.get(name))?;
        Value::from_json(self.ty, json)
    }
}

/// Type, range and further restrictions of a plain value.
type Scalar = (Type, Option<(i64, i64)>, String);

fn scalar(ty: &DataType) -> Option<Scalar> {
    let integer = |least: i64, greatest: i64| (Type::Integer, Some((least, greatest)));
    let (ty, range) = match ty.kind() {
        Kind::Boolean => (Type::Bool, None),
        Kind::Octet => integer(0, u8::MAX.into()),
        Kind::Short => integer(i16::MIN.into(), i16::MAX.into()),
        Kind::UnsignedShort => integer(0, u16::MAX.into()),
        Kind::Long => integer(i32::MIN.into(), i32::MAX.into()),
        Kind::UnsignedLong => integer(0, u32::MAX.into()),
        Kind::LongLong => (Type::Integer, None),
        Kind::UnsignedLongLong => integer(0, i64::MAX),
        Kind::Float | Kind::Double => (Type::Double, None),
        Kind::String { bound: None } => (Type::Text, None),
        // The bound includes the NUL (genom3.md 5.2).
        Kind::String { bound: Some(bound) } => {
            let most = format!("at most {} bytes", bound.saturating_sub(1));
            return Some((Type::Text, None, most));
        }
        Kind::Enum { enumerators, .. } => {
            return Some((Type::Text, None, format!("one of {}", enumerators.join(", "))));
        }
        _ => return None,
    };
    Some((ty, range, String::new()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use genom_types::{Member, ScopedName, TypeTable};
    use serde_json::json;

    /// A struct with one member of this kind.
    fn with(kind: impl FnOnce(&mut TypeTable) -> Kind) -> DataType {
        let mut table = TypeTable::default();
        let kind = kind(&mut table);
        let member = Member { name: "v".to_owned(), ty: table.add(kind) };
        let name = ScopedName::new(["demo", "set", "input"]);
        let id = table.add(Kind::Struct { name, members: vec![member] });
        DataType::new(&Arc::new(table), id).unwrap()
    }

    #[test]
    fn values_come_back_as_they_were_and_cut_ones_do_not() {
        for value in [
            Value::NotSet,
            Value::Bool(true),
            Value::Integer(-7),
            Value::Double(0.1),
            Value::Text("élan".to_owned()),
            Value::Bytes(vec![1, 2, 255]),
            Value::Bools(vec![true, false]),
            Value::Integers(vec![i64::MIN, i64::MAX]),
            Value::Doubles(vec![1.5]),
            Value::Texts(vec!["a".to_owned(), String::new()]),
        ] {
            let mut message = vec![0, 1, 0, 0];
            let mut payload = Vec::new();
            value.put(&mut payload);
            message.extend(payload);
            assert_eq!(Value::take(&mut Fields::of(&message).unwrap()), Some(value));
            for cut in 4..message.len() {
                assert_eq!(Value::take(&mut Fields::of(&message[..cut]).unwrap()), None);
            }
        }
    }

    #[test]
    fn lengths_beyond_the_message_are_refused() {
        let mut payload = Vec::new();
        Value::NotSet.put(&mut payload);
        // The type, and every length from that of the string on.
        let mut message = [&[0, 1, 0, 0][..], &payload].concat();
        message[28..].fill(255);
        assert_eq!(Value::take(&mut Fields::of(&message).unwrap()), None);
        message[4] = 10;
        assert_eq!(Value::take(&mut Fields::of(&message).unwrap()), None);
    }

    #[test]
    fn structs_of_one_plain_member_are_parameters() {
        let shape = |ty: &DataType| Shape::of(ty).unwrap();
        let small = shape(&with(|_| Kind::Short));
        assert_eq!(
            (small.name(), small.ty, small.range),
            ("v", Type::Integer, Some((-32768, 32767)))
        );
        assert_eq!(small.json(&Value::Integer(3)).unwrap(), json!({"v": 3}));
        assert_eq!(small.value(&json!({"v": -3})), Some(Value::Integer(-3)));
        assert_eq!(
            small.json(&Value::Double(3.0)).unwrap_err().to_string(),
            "it is of type integer, not double"
        );
        let double = shape(&with(|_| Kind::Double));
        for value in [0.25, f64::INFINITY, f64::NEG_INFINITY] {
            let json = double.json(&Value::Double(value)).unwrap();
            assert_eq!(double.value(&json), Some(Value::Double(value)));
        }
        let pair = shape(&with(|table| {
            let element = table.add(Kind::Boolean);
            Kind::Array { element, length: 2 }
        }));
        assert_eq!((pair.ty, pair.constraint.as_str()), (Type::Bools, "2 elements"));
        assert!(pair.json(&Value::Bools(vec![true])).is_err());
        let octets = shape(&with(|table| {
            let element = table.add(Kind::Octet);
            Kind::Sequence { element, bound: None }
        }));
        assert_eq!(octets.json(&Value::Bytes(vec![9])).unwrap(), json!({"v": [9]}));
        let mode = shape(&with(|_| Kind::Enum {
            name: ScopedName::new(["demo", "mode"]),
            enumerators: vec!["SLOW".to_owned(), "FAST".to_owned()],
        }));
        assert_eq!((mode.ty, mode.constraint.as_str()), (Type::Text, "one of SLOW, FAST"));
        let nested = with(|table| {
            let member = Member { name: "w".to_owned(), ty: table.add(Kind::Float) };
            Kind::Struct { name: ScopedName::new(["demo", "wrapped"]), members: vec![member] }
        });
        assert_eq!(shape(&nested).json(&Value::Double(0.5)).unwrap(), json!({"v": {"w": 0.5}}));
    }

    #[test]
    fn what_is_not_plain_is_no_parameter() {
        let two = with(|table| {
            let ty = table.add(Kind::Double);
            let member = |name: &str| Member { name: name.to_owned(), ty };
            let name = ScopedName::new(["demo", "state"]);
            Kind::Struct { name, members: vec![member("a"), member("b")] }
        });
        assert_eq!(Shape::of(&two), None);
        assert_eq!(Shape::of(&two.member(0).unwrap()), None);
        assert_eq!(Shape::of(&with(|_| Kind::Char)), None);
    }
}
