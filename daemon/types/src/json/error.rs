//! Errors in JSON values: where, what is wrong and what is accepted.

use serde_json::Value;
use thiserror::Error;

/// A JSON value that does not fit the type; the record was not changed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}{problem}", if path.is_empty() { String::new() } else { format!("{path}: ") })]
pub struct JsonError {
    /// Where, as `goal.x[2]`; empty for the value itself.
    pub path: String,
    /// What is wrong there.
    pub problem: Box<JsonProblem>,
}

/// What is wrong in a JSON value.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum JsonProblem {
    /// Another kind of JSON value than the type needs.
    #[error("expected {expected}, found {found}")]
    Kind {
        /// The IDL type and how its values look.
        expected: String,
        /// The value, shortened.
        found: String,
    },
    /// A number the type cannot hold.
    #[error("{found} is out of range for {ty}, which goes from {min} to {max}")]
    Range {
        /// The IDL type.
        ty: String,
        /// Number as it was written.
        found: String,
        /// Least value.
        min: String,
        /// Greatest value.
        max: String,
    },
    /// A member the type does not have.
    #[error("{ty} has no member `{name}`; {}", hint(nearest.as_deref(), known))]
    Member {
        /// The IDL type.
        ty: String,
        /// Name in the JSON value.
        name: String,
        /// The member that was probably meant.
        nearest: Option<String>,
        /// All members, separated by commas.
        known: String,
    },
    /// An enumerator the type does not have.
    #[error("{ty} has no enumerator `{name}`; {}", hint(nearest.as_deref(), known))]
    Enumerator {
        /// The IDL type.
        ty: String,
        /// Name in the JSON value.
        name: String,
        /// The enumerator that was probably meant.
        nearest: Option<String>,
        /// All enumerators, separated by commas.
        known: String,
    },
    /// More elements or bytes than the bound allows.
    #[error("{found} {unit} are too many for {ty}, which takes at most {most}")]
    TooLong {
        /// The IDL type.
        ty: String,
        /// `elements` or `bytes`.
        unit: &'static str,
        /// Number given.
        found: usize,
        /// Number allowed.
        most: usize,
    },
    /// A key of an index-keyed object that is no index, or one out of range.
    #[error("`{key}` is no index of {ty}; use \"0\" to \"{last}\"")]
    Index {
        /// The IDL type.
        ty: String,
        /// The key.
        key: String,
        /// Greatest index accepted.
        last: usize,
    },
    /// A string with a NUL inside: C ends it there.
    #[error("the string holds a NUL character, which ends strings in C; remove it")]
    Nul,
    /// A union member that the discriminant does not select.
    #[error("member `{name}` of {ty} is not selected by d = {d}; {hint}")]
    Unselected {
        /// IDL name of the union.
        ty: String,
        /// The member given.
        name: String,
        /// The discriminant, given or present.
        d: String,
        /// The way out.
        hint: String,
    },
    /// Nested deeper than [`MAX_NESTING`](crate::MAX_NESTING) allows.
    #[error("nested too deep; at most {0} levels are read")]
    Deep(usize),
    /// The system has no memory for so many elements.
    #[error("no memory for {0} elements")]
    Memory(usize),
}

fn hint(nearest: Option<&str>, known: &str) -> String {
    match nearest {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("it has {known}"),
    }
}

/// The name that was probably meant, and all of them.
pub(super) fn nearest<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> (Option<String>, String) {
    let short = name.rsplit("::").next().unwrap_or(name);
    let nearest = genom_nearest::nearest(short, known.clone()).map(str::to_owned);
    let mut list: Vec<&str> = known.take(21).collect();
    if list.len() > 20 {
        list[20] = "...";
    }
    let all = if list.is_empty() { "none".to_owned() } else { list.join(", ") };
    (nearest, all)
}

/// A JSON value, shortened for messages.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Array(elements) => format!("an array of {}", elements.len()),
        Value::Object(_) => "an object".to_owned(),
        Value::String(text) if text.chars().count() > 40 => {
            format!("the string {:?}...", text.chars().take(40).collect::<String>())
        }
        Value::String(text) => format!("the string {text:?}"),
        other => other.to_string(),
    }
}
