//! Types of services and ports as JSON Schema (2020-12), with the docs and defaults of the
//! description. Each schema is self-contained: the named types it needs are in its `$defs`.
//!
//! A schema accepts what the daemon reads (genom3.md appendix A): any members of a struct, an array
//! or some of its elements by index. Inputs of a function or activity without a default are
//! required.

use std::collections::BTreeMap;

use genom_types::{Kind, TypeId, TypeTable};
use serde_json::{Map, Value, json};

use genom_description::model::{
    Component, Direction, Parameter, ServiceIx, ServiceKind, Specification,
};

const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Inputs and outputs of every service, and every port, of a component.
#[must_use]
pub fn schema(spec: &Specification, component: &Component) -> Value {
    let types = &spec.types;
    let mut services = Map::new();
    for (ix, service) in component.services.pairs() {
        let [input, output] = service_schemas(spec, component, ix);
        let kind = match service.kind {
            ServiceKind::Attribute => "attribute",
            ServiceKind::Function => "function",
            ServiceKind::Activity => "activity",
        };
        let described = json!({"kind": kind, "doc": service.doc, "input": input, "output": output});
        services.insert(service.name.clone(), described);
    }
    let mut ports = Map::new();
    for port in &component.ports {
        let mut schema = one_type(types, port.ty);
        describe(&mut schema, port.doc.as_deref());
        ports.insert(port.name.clone(), schema);
    }
    json!({ "component": component.name, "services": services, "ports": ports })
}

/// Input and output schemas of a service; empty ones for a service that does not exist.
#[must_use]
pub fn service_schemas(
    spec: &Specification,
    component: &Component,
    service: ServiceIx,
) -> [Value; 2] {
    let service = component.services.get(service);
    let parameters = service.map_or(&[][..], |service| &service.parameters);
    // Omitted inputs of an attribute keep their values in the IDS, which the description does not
    // know.
    let keeps = service.is_some_and(|service| service.kind == ServiceKind::Attribute);
    [Direction::Out, Direction::In].map(|other| {
        let these = parameters.iter().filter(|parameter| parameter.direction != other);
        // Only inputs have defaults.
        record(&spec.types, these, other == Direction::Out && !keeps)
    })
}

fn record<'a>(
    types: &TypeTable,
    parameters: impl Iterator<Item = &'a Parameter>,
    defaults: bool,
) -> Value {
    let mut walk = Walk { types, named: BTreeMap::new() };
    let mut properties = Map::new();
    let mut required = Vec::new();
    for parameter in parameters {
        let mut schema = walk.of(parameter.ty);
        let default = parameter.default.as_ref().and_then(|default| default.value.as_ref());
        let optional = matches!(types.resolved(parameter.ty), Kind::Optional { .. });
        if defaults && default.is_none() && !optional {
            required.push(parameter.name.clone());
        }
        if let Some(default) = &parameter.default {
            describe(&mut schema, default.doc.as_deref());
            for (pointer, doc) in &default.member_docs {
                describe_member(&mut schema, pointer, doc);
            }
            if let (Some(value), Value::Object(schema), true) =
                (&default.value, &mut schema, defaults)
            {
                schema.insert("default".to_owned(), value.clone());
            }
        }
        properties.insert(parameter.name.clone(), schema);
    }
    let mut schema =
        json!({"type": "object", "properties": properties, "additionalProperties": false});
    if !required.is_empty() {
        schema["required"] = required.into();
    }
    walk.finish(schema)
}

fn one_type(types: &TypeTable, id: TypeId) -> Value {
    let mut walk = Walk { types, named: BTreeMap::new() };
    let schema = walk.of(id);
    walk.finish(schema)
}

fn describe(schema: &mut Value, doc: Option<&str>) {
    if let (Value::Object(schema), Some(doc)) = (schema, doc) {
        schema.insert("description".to_owned(), doc.into());
    }
}

/// Adds the doc of an inner member, beside the `$ref` to its type.
fn describe_member(schema: &mut Value, pointer: &str, doc: &str) {
    let mut at = schema;
    for step in pointer.split('/').skip(1) {
        let step = step.replace("~1", "/").replace("~0", "~");
        // A number is the index of an element: its doc is given to all elements.
        let place = if step.parse::<usize>().is_ok() {
            at.as_object_mut().map(|map| map.entry("items").or_insert_with(|| json!({})))
        } else {
            let properties = at
                .as_object_mut()
                .map(|map| map.entry("properties").or_insert_with(|| json!({})))
                .and_then(Value::as_object_mut);
            properties.map(|map| map.entry(step).or_insert_with(|| json!({})))
        };
        let Some(place) = place else { return };
        at = place;
    }
    describe(at, Some(doc));
}

/// Makes schemas, and collects the named types that they refer to.
struct Walk<'a> {
    types: &'a TypeTable,
    /// Schemas of named types; `null` while one is being made, since a type may contain itself.
    named: BTreeMap<String, Value>,
}

impl Walk<'_> {
    fn finish(self, mut schema: Value) -> Value {
        if let Value::Object(map) = &mut schema {
            map.insert("$schema".to_owned(), DIALECT.into());
            if !self.named.is_empty() {
                map.insert("$defs".to_owned(), json!(self.named));
            }
        }
        schema
    }

    fn of(&mut self, id: TypeId) -> Value {
        let kind = self.types.kind(id);
        let Some(name) = kind.name() else { return self.shape(id) };
        let name = name.segments().join(".");
        if !self.named.contains_key(&name) {
            self.named.insert(name.clone(), Value::Null);
            let shape = self.shape(id);
            self.named.insert(name.clone(), shape);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    fn shape(&mut self, id: TypeId) -> Value {
        let range =
            |least: i64, most: u64| json!({"type": "integer", "minimum": least, "maximum": most});
        match self.types.kind(id) {
            Kind::Boolean => json!({"type": "boolean"}),
            Kind::Char => json!({"type": "string", "minLength": 1, "maxLength": 1}),
            Kind::Octet => range(0, u8::MAX.into()),
            Kind::Short => range(i16::MIN.into(), i16::MAX.unsigned_abs().into()),
            Kind::UnsignedShort => range(0, u16::MAX.into()),
            Kind::Long => range(i32::MIN.into(), i32::MAX.unsigned_abs().into()),
            Kind::UnsignedLong => range(0, u32::MAX.into()),
            Kind::LongLong => range(i64::MIN, i64::MAX.unsigned_abs()),
            Kind::UnsignedLongLong => range(0, u64::MAX),
            // NaN is written as `null`.
            Kind::Float | Kind::Double => {
                json!({"anyOf": [{"type": "number"}, {"enum": ["inf", "-inf", null]}]})
            }
            // The bound is in bytes with the NUL; JSON counts characters, which are never more.
            Kind::String { bound } => match bound {
                Some(bound) => json!({"type": "string", "maxLength": bound.saturating_sub(1)}),
                None => json!({"type": "string"}),
            },
            Kind::Array { element, length } => {
                let (element, length) = (*element, *length);
                self.elements(element, json!({"type": "array", "maxItems": length}))
            }
            Kind::Sequence { element, bound } => {
                let list = match bound {
                    Some(bound) => json!({"type": "array", "maxItems": bound}),
                    None => json!({"type": "array"}),
                };
                let element = *element;
                self.elements(element, list)
            }
            Kind::Optional { element } => {
                let element = *element;
                json!({"anyOf": [self.of(element), {"type": "null"}]})
            }
            Kind::Enum { enumerators, .. } => json!({"enum": enumerators}),
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                let members = members.iter().map(|one| (one.name.clone(), one.ty));
                let members: Vec<_> = members.collect();
                self.object(members)
            }
            Kind::Union { discriminant, members, .. } => {
                let members = members.iter().map(|one| (one.name.clone(), one.ty)).collect();
                let (switch, mut inner) = (self.of(*discriminant), self.object(members));
                if let Value::Object(inner) = &mut inner {
                    inner.insert("maxProperties".to_owned(), 1.into());
                }
                json!({
                    "type": "object",
                    "properties": {"d": switch, "u": inner},
                    "additionalProperties": false,
                })
            }
            Kind::Typedef { target, .. } => {
                let target = *target;
                self.of(target)
            }
            Kind::Native { .. } => json!({"type": "null"}),
            Kind::Forward { .. } | Kind::Any => json!(false),
        }
    }

    /// An array of all elements, or an object of some of them by index.
    fn elements(&mut self, element: TypeId, mut list: Value) -> Value {
        let element = self.of(element);
        if let Value::Object(list) = &mut list {
            list.insert("items".to_owned(), element.clone());
        }
        json!({"anyOf": [list, {
            "type": "object",
            "patternProperties": {"^[0-9]+$": element},
            "additionalProperties": false,
        }]})
    }

    fn object(&mut self, members: Vec<(String, TypeId)>) -> Value {
        let properties: Map<_, _> =
            members.into_iter().map(|(name, ty)| (name, self.of(ty))).collect();
        json!({"type": "object", "properties": properties, "additionalProperties": false})
    }
}
