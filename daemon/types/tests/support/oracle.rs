//! A second, independent CDR encoder, from JSON and one scalar at a time: it follows the mapping
//! table directly, without plans.

use genom_types::{Kind, TypeId, TypeTable};
use serde_json::Value;

use super::support::selected;

pub(crate) struct Oracle<'a> {
    pub(crate) table: &'a TypeTable,
    pub(crate) big_endian: bool,
    pub(crate) out: Vec<u8>,
}

impl Oracle<'_> {
    fn scalar<const N: usize>(&mut self, mut little: [u8; N]) {
        while !self.out.len().is_multiple_of(N) {
            self.out.push(0);
        }
        if self.big_endian {
            little.reverse();
        }
        self.out.extend(little);
    }

    fn length(&mut self, length: usize) {
        self.scalar((length as u32).to_le_bytes());
    }

    pub(crate) fn value(&mut self, id: TypeId, value: &Value) {
        let signed = || value.as_i64().unwrap_or_default();
        let unsigned = || value.as_u64().unwrap_or_default();
        let real = || match value {
            Value::Null => f64::NAN,
            Value::String(text) if text == "inf" => f64::INFINITY,
            Value::String(_) => f64::NEG_INFINITY,
            number => number.as_f64().unwrap(),
        };
        match self.table.resolved(id) {
            Kind::Boolean => self.scalar([u8::from(value.as_bool().unwrap())]),
            Kind::Char => {
                let c = value.as_str().unwrap().chars().next().unwrap();
                self.scalar([u32::from(c) as u8]);
            }
            Kind::Octet => self.scalar([unsigned() as u8]),
            Kind::Short => self.scalar((signed() as i16).to_le_bytes()),
            Kind::UnsignedShort => self.scalar((unsigned() as u16).to_le_bytes()),
            Kind::Long => self.scalar((signed() as i32).to_le_bytes()),
            Kind::UnsignedLong => self.scalar((unsigned() as u32).to_le_bytes()),
            Kind::LongLong => self.scalar(signed().to_le_bytes()),
            Kind::UnsignedLongLong => self.scalar(unsigned().to_le_bytes()),
            Kind::Float => self.scalar((real() as f32).to_le_bytes()),
            Kind::Double => self.scalar(real().to_le_bytes()),
            Kind::Enum { enumerators, .. } => {
                let rank = enumerators.iter().position(|e| Some(e.as_str()) == value.as_str());
                self.scalar((rank.unwrap() as u32).to_le_bytes());
            }
            Kind::String { .. } => {
                let text = value.as_str().unwrap();
                self.length(text.len() + 1);
                self.out.extend(text.bytes());
                self.out.push(0);
            }
            Kind::Array { element, .. } => {
                value.as_array().unwrap().iter().for_each(|v| self.value(*element, v));
            }
            Kind::Sequence { element, .. } => {
                let elements = value.as_array().unwrap();
                self.length(elements.len());
                elements.iter().for_each(|v| self.value(*element, v));
            }
            Kind::Optional { .. } if value.is_null() => self.length(0),
            Kind::Optional { element } => {
                self.length(1);
                self.value(*element, value);
            }
            Kind::Struct { members, .. } => {
                members.iter().for_each(|m| self.value(m.ty, &value[&m.name]));
            }
            Kind::Union { discriminant, members, .. } => {
                self.value(*discriminant, &value["d"]);
                let chosen = selected(self.table, *discriminant, members, &value["d"]);
                for m in members {
                    let present = chosen.is_some_and(|chosen| chosen.name == m.name);
                    self.length(usize::from(present));
                    if present {
                        self.value(m.ty, &value["u"][&m.name]);
                    }
                }
            }
            other => panic!("{other:?} has no CDR form"),
        }
    }
}
