//! Random types and random values of them, from a seed. Not a test by itself.

#![allow(dead_code)] // each test uses a part of it
#![allow(clippy::panic, reason = "a test")]

use genom_types::{Kind, Label, Member, ScopedName, TypeId, TypeTable, UnionMember};
use serde_json::{Map, Value, json};

/// A generator of pseudo-random numbers: xorshift64*.
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number below `n`.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        (self.next() >> 11) % n
    }

    pub(crate) fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }
}

/// Makes types; `fixed` leaves out those that own memory.
pub(crate) struct Types<'a> {
    pub(crate) table: &'a mut TypeTable,
    pub(crate) rng: &'a mut Rng,
    pub(crate) fixed: bool,
    pub(crate) count: u32,
}

impl Types<'_> {
    fn name(&mut self, kind: &str) -> ScopedName {
        self.count += 1;
        ScopedName::new(["m".to_owned(), format!("{kind}{}", self.count)])
    }

    fn scalar(&mut self) -> TypeId {
        let kinds = [
            Kind::Boolean,
            Kind::Char,
            Kind::Octet,
            Kind::Short,
            Kind::UnsignedShort,
            Kind::Long,
            Kind::UnsignedLong,
            Kind::LongLong,
            Kind::UnsignedLongLong,
            Kind::Float,
            Kind::Double,
        ];
        let rank = self.rng.below(kinds.len() as u64) as usize;
        self.table.add(kinds[rank].clone())
    }

    fn color(&mut self) -> TypeId {
        let name = self.name("e");
        let enumerators = (0..=self.rng.below(4)).map(|i| format!("{}_{i}", name.last())).collect();
        self.table.add(Kind::Enum { name, enumerators })
    }

    pub(crate) fn any(&mut self, depth: u32) -> TypeId {
        if depth == 0 {
            return match self.rng.below(8) {
                0 => self.color(),
                1 => {
                    let bound = Some(1 + self.rng.below(9) as u32);
                    self.table.add(Kind::String { bound })
                }
                2 if !self.fixed => self.table.add(Kind::String { bound: None }),
                _ => self.scalar(),
            };
        }
        match self.rng.below(8) {
            0 => {
                let (element, length) = (self.any(depth - 1), self.rng.below(7) as u32);
                self.table.add(Kind::Array { element, length })
            }
            1 | 2 => {
                let mut element = self.any(depth - 1);
                if self.is_empty(element) {
                    element = self.table.add(Kind::Octet);
                }
                let bound = (self.fixed || self.rng.one_in(2)).then(|| self.rng.below(6) as u32);
                self.table.add(Kind::Sequence { element, bound })
            }
            3 => {
                let element = self.any(depth - 1);
                // `null` always means absent, so a nested optional or a NaN cannot be the value.
                let element = match self.table.resolved(element) {
                    Kind::Optional { .. } | Kind::Float | Kind::Double => self.color(),
                    _ => element,
                };
                self.table.add(Kind::Optional { element })
            }
            4 => self.union(depth),
            5 => {
                let (target, name) = (self.any(depth - 1), self.name("t"));
                self.table.add(Kind::Typedef { name, target })
            }
            _ => self.structure(depth),
        }
    }

    /// Whether values of the type have size 0.
    fn is_empty(&self, id: TypeId) -> bool {
        match self.table.resolved(id) {
            Kind::Array { element, length } => *length == 0 || self.is_empty(*element),
            Kind::Struct { members, .. } => members.iter().all(|m| self.is_empty(m.ty)),
            _ => false,
        }
    }

    pub(crate) fn structure(&mut self, depth: u32) -> TypeId {
        let members = (0..=self.rng.below(6))
            .map(|i| Member { name: format!("m{i}"), ty: self.any(depth - 1) })
            .collect();
        let name = self.name("s");
        self.table.add(Kind::Struct { name, members })
    }

    fn union(&mut self, depth: u32) -> TypeId {
        let name = self.name("u");
        let (discriminant, labels): (_, Vec<i128>) = match self.rng.below(4) {
            0 => (self.table.add(Kind::Boolean), vec![0, 1]),
            1 => (self.table.add(Kind::Char), vec![97, 98, -3]),
            2 => {
                let id = self.color();
                let Kind::Enum { enumerators, .. } = self.table.kind(id) else {
                    panic!("made above")
                };
                (id, (0..enumerators.len() as i128).collect())
            }
            _ => (self.table.add(Kind::Short), vec![-300, 0, 7, 12]),
        };
        let with_default = self.rng.one_in(2);
        let count = labels.len();
        let members = labels
            .into_iter()
            .enumerate()
            .map(|(i, label)| {
                let mut labels = vec![Label::Value(label)];
                if i + 1 == count && with_default {
                    labels = vec![Label::Default];
                }
                UnionMember { name: format!("c{i}"), ty: self.any(depth - 1), labels }
            })
            .collect();
        self.table.add(Kind::Union { name, discriminant, members })
    }
}

/// A value of a type, as `to_json` writes it.
pub(crate) fn value(table: &TypeTable, id: TypeId, rng: &mut Rng) -> Value {
    let edge = rng.below(8);
    match table.resolved(id) {
        Kind::Boolean => json!(rng.one_in(2)),
        Kind::Char => json!(char::from(rng.next() as u8).to_string()),
        Kind::Octet => json!(rng.next() as u8),
        Kind::Short => json!(rng.next() as i16),
        Kind::UnsignedShort => json!(rng.next() as u16),
        Kind::Long => json!(if edge == 0 { i32::MIN } else { rng.next() as i32 }),
        Kind::UnsignedLong => json!(if edge == 0 { u32::MAX } else { rng.next() as u32 }),
        Kind::LongLong => json!(if edge == 0 { i64::MIN } else { rng.next() as i64 }),
        Kind::UnsignedLongLong => json!(if edge == 0 { u64::MAX } else { rng.next() }),
        Kind::Float | Kind::Double if edge == 0 => Value::Null,
        Kind::Float | Kind::Double if edge == 1 => json!("-inf"),
        Kind::Float => {
            // Any finite float, by its shortest decimal form, as it is written.
            let bits = f32::from_bits(rng.next() as u32);
            let float = if bits.is_finite() { bits } else { 0.1 };
            json!(float.to_string().parse::<f64>().unwrap())
        }
        Kind::Double => json!(rng.next() as i64 as f64 / 1e6),
        Kind::String { bound } => {
            let most = bound.map_or(20, |bound| u64::from(bound) - 1);
            let length = rng.below(most + 1);
            let mut text = String::new();
            while (text.len() as u64) < length {
                let c = *['a', 'Z', '"', '\\', '\n', 'é', '€'].get(rng.below(7) as usize).unwrap();
                text.push(if text.len() + c.len_utf8() > most as usize { '.' } else { c });
            }
            json!(text)
        }
        Kind::Array { element, length } => {
            (0..*length).map(|_| value(table, *element, rng)).collect()
        }
        Kind::Sequence { element, bound } => {
            let length = rng.below(bound.map_or(5, u64::from) + 1);
            (0..length).map(|_| value(table, *element, rng)).collect()
        }
        Kind::Optional { .. } if edge < 3 => Value::Null,
        Kind::Optional { element } => value(table, *element, rng),
        Kind::Enum { enumerators, .. } => {
            json!(enumerators[rng.below(enumerators.len() as u64) as usize])
        }
        Kind::Struct { members, .. } => members
            .iter()
            .map(|m| (m.name.clone(), value(table, m.ty, rng)))
            .collect::<Map<_, _>>()
            .into(),
        Kind::Union { discriminant, members, .. } => {
            let d = value(table, *discriminant, rng);
            let u: Map<String, Value> = selected(table, *discriminant, members, &d)
                .map(|m| (m.name.clone(), value(table, m.ty, rng)))
                .into_iter()
                .collect();
            json!({"d": d, "u": u})
        }
        other => panic!("{other:?} has no values"),
    }
}

/// The union member that a discriminant in JSON selects.
pub(crate) fn selected<'a>(
    table: &TypeTable,
    discriminant: TypeId,
    members: &'a [UnionMember],
    d: &Value,
) -> Option<&'a UnionMember> {
    let d = match (table.resolved(discriminant), d) {
        (Kind::Enum { enumerators, .. }, Value::String(name)) => {
            enumerators.iter().position(|e| e == name).unwrap() as i128
        }
        (_, Value::Bool(d)) => i128::from(*d),
        (_, Value::String(c)) => i128::from(u32::from(c.chars().next().unwrap()) as u8 as i8),
        (_, d) => i128::from(d.as_i64().unwrap()),
    };
    let has = |label| members.iter().find(|m| m.labels.contains(&label));
    has(Label::Value(d)).or_else(|| has(Label::Default))
}
