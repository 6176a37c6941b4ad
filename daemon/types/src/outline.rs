//! The memory layout of types as JSON, for programs that share memory with this one.
//!
//! The types that a type consists of are listed once each, and refer to each other by index. This
//! works for recursive types as well.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::{DataType, Kind, Label, TypeId, UnionMember};

/// Types of one table, each listed once; others that they consist of follow.
#[derive(Debug, Default)]
pub struct Outline {
    all: Vec<DataType>,
    places: BTreeMap<TypeId, usize>,
}

impl Outline {
    /// Index of a type in the list.
    pub fn place(&mut self, ty: DataType) -> usize {
        let place = *self.places.entry(ty.id()).or_insert(self.all.len());
        if place == self.all.len() {
            self.all.push(ty);
        }
        place
    }

    /// The list.
    #[must_use]
    pub fn types(mut self) -> Vec<Map<String, Value>> {
        let mut described = Vec::new();
        while let Some(next) = self.all.get(described.len()).cloned() {
            described.push(self.describe(&next));
        }
        described
    }

    /// The same; `null` for none.
    fn place_of(&mut self, ty: Option<DataType>) -> Value {
        ty.map_or(Value::Null, |ty| self.place(ty).into())
    }

    fn describe(&mut self, ty: &DataType) -> Map<String, Value> {
        let mut out = Map::new();
        out.insert("kind".into(), ty.kind().keyword().into());
        out.insert("name".into(), ty.name().into());
        // For a typedef, the name of the type it stands for.
        if let Some(name) = ty.kind().name() {
            out.insert("full_name".into(), name.to_string().into());
        }
        out.insert("size".into(), ty.size().into());
        out.insert("align".into(), ty.align().into());
        out.insert("fixed".into(), ty.is_fixed_size().into());
        match ty.kind() {
            Kind::Struct { .. } | Kind::Exception { .. } => {
                out.insert("members".into(), self.members(ty, &[]));
            }
            Kind::Union { discriminant, members, .. } => {
                let switched = DataType::new(ty.table(), *discriminant).ok();
                out.insert("discriminant".into(), self.place_of(switched));
                out.insert("members".into(), self.members(ty, members));
            }
            Kind::Enum { enumerators, .. } => {
                out.insert("enumerators".into(), json!(enumerators));
            }
            Kind::String { bound } => {
                out.insert("bound".into(), json!(bound));
            }
            Kind::Sequence { bound, .. } => {
                out.insert("bound".into(), json!(bound));
                out.insert("element".into(), self.place_of(ty.element()));
                out.insert("offsets".into(), json!(ty.layout().offsets));
            }
            Kind::Array { length, .. } => {
                out.insert("length".into(), json!(length));
                out.insert("element".into(), self.place_of(ty.element()));
            }
            Kind::Optional { .. } => {
                out.insert("element".into(), self.place_of(ty.element()));
                out.insert("offsets".into(), json!(ty.layout().offsets));
            }
            _ => {}
        }
        out
    }

    fn members(&mut self, ty: &DataType, cases: &[UnionMember]) -> Value {
        let mut members = Vec::new();
        for index in 0..ty.member_count() {
            let place = self.place_of(ty.member(index));
            let mut member = json!({
                "name": ty.member_name(index),
                "offset": ty.member_offset(index),
                "type": place,
            });
            if let (Some(case), Some(member)) = (cases.get(index), member.as_object_mut()) {
                let labels: Vec<Value> = case.labels.iter().copied().map(label).collect();
                member.insert("labels".into(), labels.into());
            }
            members.push(member);
        }
        members.into()
    }
}

/// A `case` label as a number, `null` for `default`.
fn label(label: Label) -> Value {
    match label {
        Label::Value(value) => i64::try_from(value)
            .map_or_else(|_| json!(u64::try_from(value).ok()), |value| json!(value)),
        Label::Default => Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::{Member, ScopedName, TypeTable};

    #[test]
    fn a_type_that_contains_itself_is_described_once() {
        let mut table = TypeTable::default();
        let name = ScopedName::new(["m", "node"]);
        let node = table.add(Kind::Forward { name: name.clone(), union: false });
        let nodes = table.add(Kind::Sequence { element: node, bound: None });
        let members = vec![Member { name: "next".to_owned(), ty: nodes }];
        table.complete(node, Kind::Struct { name, members });
        let mut outline = Outline::default();
        let node = DataType::new(&Arc::new(table), node).unwrap();
        assert_eq!((outline.place(node.clone()), outline.place(node)), (0, 0));
        let types = outline.types();
        assert_eq!(types.len(), 2);
        assert_eq!(types[0]["members"][0]["type"], 1);
        assert_eq!(types[1]["element"], 0);
        assert_eq!(types[1]["offsets"], json!([0, 4, 8, 16]));
    }
}
