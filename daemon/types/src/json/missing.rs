//! Finds the first datum of a value that none of the JSON values gives from which it was merged.

use serde_json::Value;

use crate::graph::Shape;
use crate::json::read::{push_index, push_name};
use crate::layout::MAX_NESTING;
use crate::memory::View;

/// Path of the first datum of `value` that none of `given` sets, as `goal.x[2]`; `given` begins
/// with the JSON value merged last.
pub(crate) fn missing(value: View<'_>, given: &[&Value]) -> Option<String> {
    let mut path = String::new();
    find(value, given, &mut path, 0).then_some(path)
}

/// Whether something is missing; if so, `path` leads to it.
fn find(value: View<'_>, given: &[&Value], path: &mut String, depth: usize) -> bool {
    if depth > MAX_NESTING {
        return false;
    }
    match &value.node().shape {
        Shape::Scalar(_) | Shape::Enum { .. } | Shape::Text { .. } => given.is_empty(),
        // Only codels know the content.
        Shape::Native => false,
        Shape::Struct { .. } => {
            let mut members = value.members();
            members.any(|(name, member)| {
                let given: Vec<_> = given.iter().filter_map(|json| json.get(name)).collect();
                inside(member, &given, path, depth, |path| push_name(path, name))
            })
        }
        Shape::Array { .. } | Shape::Sequence { .. } => {
            // No JSON value gives the length of the sequence, or any element.
            if given.is_empty() {
                return true;
            }
            let mut elements = value.elements().enumerate();
            elements.any(|(index, element)| {
                let key = index.to_string();
                let of = |json: &&'_ Value| match json {
                    Value::Array(all) => all.get(index).is_some(),
                    keyed => keyed.get(&key).is_some(),
                };
                let given: Vec<_> = given
                    .iter()
                    .filter(|json| of(json))
                    .map(|json| if json.is_array() { &json[index] } else { &json[&key] })
                    .collect();
                inside(element, &given, path, depth, |path| push_index(path, index))
            })
        }
        // An optional that no JSON value gives is absent, and may be.
        Shape::Optional { .. } => value.value().is_some_and(|inner| {
            let given: Vec<_> = given.iter().copied().take_while(|json| !json.is_null()).collect();
            find(inner, &given, path, depth + 1)
        }),
        Shape::Union { .. } => {
            if !given.iter().any(|json| json.get("d").is_some()) {
                return inside_missing(path, "d");
            }
            let Some((name, member)) = value.active() else { return false };
            let given: Vec<_> = given.iter().filter_map(|json| json.get("u")?.get(name)).collect();
            inside(member, &given, path, depth, |path| {
                push_name(path, "u");
                push_name(path, name);
            })
        }
    }
}

fn inside_missing(path: &mut String, name: &str) -> bool {
    push_name(path, name);
    true
}

/// Descends into a part of the value; restores the path when nothing is missing there.
fn inside(
    value: View<'_>,
    given: &[&Value],
    path: &mut String,
    depth: usize,
    step: impl FnOnce(&mut String),
) -> bool {
    let length = path.len();
    step(path);
    let missing = find(value, given, path, depth + 1);
    if !missing {
        path.truncate(length);
    }
    missing
}
