//! Default values and documentation of parameters (genom3.md 2.4, 3.8).

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use genom_types::{Kind, Label, TypeId};
use serde_json::{Map, Value as Json};

use super::Checker;
use super::room::of_json;
use crate::diagnostic::Diagnostic;
use crate::model::{Default as DefaultValue, Span};
use crate::syntax::{InitialStep, InitialValue, Initializer};

/// Docs found so far, and the JSON pointer to the current member.
#[derive(Default)]
struct Place {
    pointer: String,
    docs: Vec<(String, String)>,
}

/// The initialiser is refused, and this has been reported.
struct Refused;

impl Checker {
    /// Evaluates an initialiser for a value of type `ty`. A wrong one is dropped as a whole.
    pub(super) fn initial(&mut self, init: &Initializer, ty: TypeId) -> Option<DefaultValue> {
        let mut place = Place::default();
        // `= [2] = 4` is a compound of one element.
        let value = if init.step.is_some() {
            Some(self.compound(std::slice::from_ref(init), ty, init.span, &mut place))
        } else {
            init.value.as_ref().map(|value| self.value(value, ty, init.span, &mut place))
        };
        let doc = init.doc.as_ref().filter(|_| init.step.is_none()).map(|doc| doc.text.clone());
        let value = match value {
            None => None,
            Some(Ok(value)) => Some(value),
            Some(Err(Refused)) => return None,
        };
        Some(DefaultValue { value, doc, member_docs: place.docs })
    }

    fn value(
        &mut self,
        value: &InitialValue,
        ty: TypeId,
        span: Span,
        place: &mut Place,
    ) -> Result<Json, Refused> {
        let walked = self.walked(ty);
        let record = matches!(
            self.types.kind(walked),
            Kind::Struct { .. }
                | Kind::Exception { .. }
                | Kind::Union { .. }
                | Kind::Array { .. }
                | Kind::Sequence { .. }
        );
        match value {
            InitialValue::Compound(items) if record => self.compound(items, walked, span, place),
            // V1.
            InitialValue::Compound(_) => {
                if !self.is_error(walked) {
                    let message = format!("`{{...}}` cannot initialise {}", self.type_name(walked));
                    self.push(Diagnostic::error("E0801", span, message));
                }
                Err(Refused)
            }
            // V2.
            InitialValue::Scalar(_) if record => {
                let message = format!("{} needs `{{...}}`, not one value", self.type_name(walked));
                self.push(Diagnostic::error("E0802", span, message));
                Err(Refused)
            }
            // V3, in place of C5.
            InitialValue::Scalar(expression) => {
                let value = self.evaluate(expression).ok_or(Refused)?;
                let value = self.fit(value, walked, expression.span, "E0803").ok_or(Refused)?;
                let value = self.json(&value, walked);
                if self.reserve(of_json(&value), span) { Ok(value) } else { Err(Refused) }
            }
        }
    }

    fn compound(
        &mut self,
        items: &[Initializer],
        ty: TypeId,
        span: Span,
        place: &mut Place,
    ) -> Result<Json, Refused> {
        let ty = self.walked(ty);
        match *self.types.kind(ty) {
            Kind::Struct { .. } | Kind::Exception { .. } | Kind::Union { .. } => {
                self.record(items, ty, place)
            }
            Kind::Array { element, length } => {
                self.elements(items, ty, element, Some(length), true, place)
            }
            Kind::Sequence { element, bound } => {
                self.elements(items, ty, element, bound, false, place)
            }
            _ => {
                let message = format!("`{{...}}` cannot initialise {}", self.type_name(ty));
                self.push(Diagnostic::error("E0801", span, message));
                Err(Refused)
            }
        }
    }

    fn record(
        &mut self,
        items: &[Initializer],
        ty: TypeId,
        place: &mut Place,
    ) -> Result<Json, Refused> {
        let union = matches!(self.types.kind(ty), Kind::Union { .. });
        let mut given: HashMap<usize, Span> = HashMap::new();
        let mut object = Map::new();
        let mut last = None;
        let mut next = 0;
        for item in items {
            let rank = match &item.step {
                None => next,
                Some(InitialStep::Member(name)) => match self.member(ty, &name.text) {
                    Some((rank, _)) => rank,
                    // V6.
                    None => return Err(self.unknown_member(&name.text, ty, name.span)),
                },
                // V7.
                Some(InitialStep::Index(index)) => {
                    let message = format!("{} has no elements by index", self.type_name(ty));
                    self.push(Diagnostic::error("E0807", index.span, message));
                    return Err(Refused);
                }
            };
            next = rank + 1;
            let slot = match self.types.kind(ty) {
                Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                    members.get(rank).map(|m| (m.name.clone(), m.ty))
                }
                Kind::Union { members, .. } => members.get(rank).map(|m| (m.name.clone(), m.ty)),
                _ => None,
            };
            let Some((name, member)) = slot else {
                // V4.
                let message = format!("too many values for {}", self.type_name(ty));
                self.push(Diagnostic::error("E0804", item.span, message));
                return Err(Refused);
            };
            // appendix A: members of a union lie under "u".
            let step = if union { format!("u/{name}") } else { name.clone() };
            if let Some(value) = self.item(item, member, &step, place)? {
                self.once(&mut given, rank, item.span, || format!("member `{name}`"));
                object.insert(name, value);
                last = Some(rank);
            }
        }
        if !union {
            return Ok(Json::Object(object));
        }
        // Only one member can be set: the last one given.
        let Some(rank) = last else { return Ok(Json::Object(Map::new())) };
        let Kind::Union { members, discriminant, .. } = self.types.kind(ty) else {
            return Err(Refused);
        };
        let Some(member) = members.get(rank) else { return Err(Refused) };
        let mut inner = Map::new();
        if let Some(value) = object.remove(&member.name) {
            inner.insert(member.name.clone(), value);
        }
        let mut result = Map::new();
        let label = member.labels.iter().find_map(|label| match label {
            Label::Value(v) => Some(*v),
            Label::Default => None,
        });
        let d = label.or_else(|| self.free_label(ty));
        if let Some(d) = d.and_then(|d| self.label_json(d, *discriminant)) {
            result.insert("d".to_owned(), d);
        }
        result.insert("u".to_owned(), Json::Object(inner));
        Ok(Json::Object(result))
    }

    /// The smallest value that is no label of the union: it selects `default`.
    fn free_label(&self, ty: TypeId) -> Option<i128> {
        let Kind::Union { members, .. } = self.types.kind(ty) else { return None };
        let labels = members.iter().flat_map(|m| &m.labels);
        let taken: HashSet<i128> = labels
            .filter_map(|label| match label {
                Label::Value(value) => Some(*value),
                Label::Default => None,
            })
            .collect();
        (0..=taken.len() as i128).find(|value| !taken.contains(value))
    }

    fn label_json(&self, label: i128, discriminant: TypeId) -> Option<Json> {
        Some(match self.types.resolved(discriminant) {
            Kind::Boolean => Json::from(label != 0),
            Kind::Char => {
                let code = u8::try_from(label.rem_euclid(256)).ok()?;
                Json::from(char::from(code).to_string())
            }
            Kind::Enum { enumerators, .. } => {
                Json::from(enumerators.get(usize::try_from(label).ok()?)?.as_str())
            }
            _ => match i64::try_from(label) {
                Ok(v) => Json::from(v),
                Err(_) => Json::from(u64::try_from(label).ok()?),
            },
        })
    }

    fn elements(
        &mut self,
        items: &[Initializer],
        ty: TypeId,
        element: TypeId,
        bound: Option<u32>,
        whole: bool,
        place: &mut Place,
    ) -> Result<Json, Refused> {
        let mut found: Vec<(u32, Json)> = Vec::new();
        let mut given: HashMap<u32, Span> = HashMap::new();
        let mut next = 0;
        for item in items {
            let rank = match &item.step {
                None => next,
                Some(InitialStep::Index(index)) => self.positive_u32(index).ok_or(Refused)?,
                // V6.
                Some(InitialStep::Member(name)) => {
                    return Err(self.unknown_member(&name.text, ty, name.span));
                }
            };
            // V5.
            if bound.is_some_and(|bound| rank >= bound) {
                let message = format!("element {rank} is out of bounds in {}", self.type_name(ty));
                self.push(Diagnostic::error("E0805", item.span, message));
                return Err(Refused);
            }
            next = rank.saturating_add(1);
            if let Some(value) = self.item(item, element, &rank.to_string(), place)? {
                self.once(&mut given, rank, item.span, || format!("element {rank}"));
                found.push((rank, value));
            }
        }
        let in_order = found.iter().zip(0u32..).all(|((rank, _), at)| *rank == at);
        let complete = !whole || u32::try_from(found.len()).ok() == bound;
        if in_order && complete {
            return Ok(found.into_iter().map(|(_, value)| value).collect());
        }
        // appendix A: some elements only, by index.
        Ok(found.into_iter().map(|(rank, value)| (rank.to_string(), value)).collect())
    }

    fn item(
        &mut self,
        item: &Initializer,
        ty: TypeId,
        step: &str,
        place: &mut Place,
    ) -> Result<Option<Json>, Refused> {
        let length = place.pointer.len();
        place.pointer.push('/');
        place.pointer.push_str(step);
        if let Some(doc) = &item.doc {
            // A doc is stored with its JSON pointer, which may be longer than the doc itself.
            if !self.reserve(place.pointer.len() + doc.text.len(), item.span) {
                return Err(Refused);
            }
            place.docs.push((place.pointer.clone(), doc.text.clone()));
        }
        let value = item.value.as_ref().map(|value| self.value(value, ty, item.span, place));
        place.pointer.truncate(length);
        value.transpose()
    }

    /// Warns of a value that replaces an earlier one in the same braces.
    fn once<K: Eq + Hash>(
        &mut self,
        given: &mut HashMap<K, Span>,
        what: K,
        span: Span,
        name: impl FnOnce() -> String,
    ) {
        if let Some(first) = given.insert(what, span) {
            let message = format!("{} is given a value twice, this one holds", name());
            self.push(Diagnostic::warning("W0907", span, message).note(first, "first here"));
        }
    }

    fn unknown_member(&mut self, name: &str, ty: TypeId, span: Span) -> Refused {
        if !self.lost.contains(name) && !self.is_error(ty) {
            let message = format!("unknown member `{name}` in {}", self.type_name(ty));
            let help = self.suggest(name, |this| this.member_names(ty));
            let mut error = Diagnostic::error("E0806", span, message);
            error.help = help;
            self.push(error);
        }
        Refused
    }

    pub(super) fn member_names(&self, ty: TypeId) -> Vec<&str> {
        match self.types.kind(ty) {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                members.iter().map(|m| m.name.as_str()).collect()
            }
            Kind::Union { members, .. } => members.iter().map(|m| m.name.as_str()).collect(),
            _ => Vec::new(),
        }
    }
}
