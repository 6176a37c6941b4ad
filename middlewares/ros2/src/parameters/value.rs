//! Values of ROS parameters, and their conversion from and to IDL types.

use genom_types::{DataType, Kind};
use ros2_client::parameters::{ParameterType as Type, ParameterValue as Value};
use serde_json::{Map, Number, Value as Json};

use super::error::SetError;

/// Greatest depth of nested structs with one member each that are followed.
const DEEPEST: usize = 8;

/// Name of a type in ROS.
pub(super) fn name_of(ty: Type) -> &'static str {
    match ty {
        Type::NotSet => "not set",
        Type::Bool => "bool",
        Type::Integer => "integer",
        Type::Double => "double",
        Type::String => "string",
        Type::ByteArray => "byte array",
        Type::BoolArray => "bool array",
        Type::IntegerArray => "integer array",
        Type::DoubleArray => "double array",
        Type::StringArray => "string array",
    }
}

fn to_json(value: &Value) -> Json {
    let double = |value: &f64| match *value {
        f64::INFINITY => Json::from("inf"),
        f64::NEG_INFINITY => Json::from("-inf"),
        // JSON has no NaN: it becomes null.
        value => Number::from_f64(value).map_or(Json::Null, Json::Number),
    };
    match value {
        Value::NotSet => Json::Null,
        Value::Boolean(value) => (*value).into(),
        Value::Integer(value) => (*value).into(),
        Value::Double(value) => double(value),
        Value::String(text) => text.as_str().into(),
        Value::ByteArray(bytes) => bytes.as_slice().into(),
        Value::BooleanArray(all) => all.as_slice().into(),
        Value::IntegerArray(all) => all.as_slice().into(),
        Value::DoubleArray(all) => all.iter().map(double).collect(),
        Value::StringArray(all) => all.as_slice().into(),
    }
}

fn from_json(ty: Type, json: &Json) -> Option<Value> {
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
        Type::NotSet => Value::NotSet,
        Type::Bool => Value::Boolean(json.as_bool()?),
        Type::Integer => Value::Integer(json.as_i64()?),
        Type::Double => Value::Double(double(json)?),
        Type::String => Value::String(text(json)?),
        Type::ByteArray => Value::ByteArray(each(json, byte)?),
        Type::BoolArray => Value::BooleanArray(each(json, Json::as_bool)?),
        Type::IntegerArray => Value::IntegerArray(each(json, Json::as_i64)?),
        Type::DoubleArray => Value::DoubleArray(each(json, double)?),
        Type::StringArray => Value::StringArray(each(json, text)?),
    })
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
            Type::Bool => Type::BoolArray,
            Type::Integer if matches!(element.kind(), Kind::Octet) => Type::ByteArray,
            Type::Integer => Type::IntegerArray,
            Type::Double => Type::DoubleArray,
            _ => Type::StringArray,
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
        let given = value.to_parameter_type();
        if given != self.ty {
            return Err(SetError::Type { wanted: name_of(self.ty), given: name_of(given) });
        }
        let json = to_json(value);
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
        from_json(self.ty, json)
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
        Kind::String { bound: None } => (Type::String, None),
        // The bound includes the NUL (genom3.md 5.2).
        Kind::String { bound: Some(bound) } => {
            let most = format!("at most {} bytes", bound.saturating_sub(1));
            return Some((Type::String, None, most));
        }
        Kind::Enum { enumerators, .. } => {
            return Some((Type::String, None, format!("one of {}", enumerators.join(", "))));
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
        assert_eq!((pair.ty, pair.constraint.as_str()), (Type::BoolArray, "2 elements"));
        assert!(pair.json(&Value::BooleanArray(vec![true])).is_err());
        let octets = shape(&with(|table| {
            let element = table.add(Kind::Octet);
            Kind::Sequence { element, bound: None }
        }));
        assert_eq!(octets.json(&Value::ByteArray(vec![9])).unwrap(), json!({"v": [9]}));
        let mode = shape(&with(|_| Kind::Enum {
            name: ScopedName::new(["demo", "mode"]),
            enumerators: vec!["SLOW".to_owned(), "FAST".to_owned()],
        }));
        assert_eq!((mode.ty, mode.constraint.as_str()), (Type::String, "one of SLOW, FAST"));
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
