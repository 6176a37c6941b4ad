//! Compares the encodings of two interfaces; names of members do not matter.
//!
//! Bounds of strings and sequences may differ, since they do not affect the encoding; a sample that
//! is too long for the reader is refused when it arrives.

use std::fmt::Write as _;

use crate::interface::{Base, Field, Message, Shape};
use crate::names::TypeName;

/// Greatest nesting depth that is compared.
const DEEPEST: usize = 64;

/// Looks up messages by name.
pub type Find<'a> = &'a dyn Fn(&TypeName) -> Option<Message>;

/// The structures differ, or cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{ours} and {theirs} differ {place}\n{shown}")]
pub struct Difference {
    /// Our name of the type.
    pub ours: String,
    /// The foreign type.
    pub theirs: TypeName,
    /// Where the first difference is: `at member 2, ...`.
    pub place: String,
    /// Both structures, one below the other.
    pub shown: String,
}

/// What is encoded, one value after the other; structs add nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Wire {
    Value(Base),
    Array(u32, Vec<Leaf>),
    Sequence(Vec<Leaf>),
}

/// A value and the path to it.
#[derive(Clone, Debug)]
struct Leaf {
    path: String,
    wire: Wire,
}

impl PartialEq for Leaf {
    fn eq(&self, other: &Self) -> bool {
        self.wire == other.wire
    }
}

impl Eq for Leaf {}

/// Compares our type with a foreign one. `ours` and `theirs` look up the messages within.
///
/// # Errors
/// They differ, or a message within is unknown.
pub fn compare(
    name: &str,
    ours: (&Message, Find<'_>),
    theirs: (&Message, Find<'_>),
) -> Result<(), Box<Difference>> {
    let differ = |place: String| {
        let mut shown = format!("{name} is\n");
        show(ours.0, ours.1, 1, &mut shown);
        _ = writeln!(shown, "{} is", theirs.0.name);
        show(theirs.0, theirs.1, 1, &mut shown);
        shown.truncate(shown.trim_end().len());
        let theirs = theirs.0.name.clone();
        Box::new(Difference { ours: name.to_owned(), theirs, place, shown })
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    flatten(ours.0, ours.1, "", DEEPEST, &mut a)
        .and_then(|()| flatten(theirs.0, theirs.1, "", DEEPEST, &mut b))
        .map_err(|missing| differ(format!("as far as is known: {missing} is not")))?;
    for (mine, other) in a.iter().zip(&b) {
        if mine != other {
            return Err(differ(format!("at `{}`, there `{}`:", mine.path, other.path)));
        }
    }
    let more = |path: &str, has: &str| differ(format!("at `{path}`, which only {has} has:"));
    match (a.get(b.len()), b.get(a.len())) {
        (Some(mine), _) => Err(more(&mine.path, name)),
        (_, Some(other)) => Err(more(&other.path, &theirs.0.name.to_string())),
        (None, None) => Ok(()),
    }
}

fn flatten(
    message: &Message,
    find: Find<'_>,
    path: &str,
    depth: usize,
    out: &mut Vec<Leaf>,
) -> Result<(), TypeName> {
    for field in &message.fields {
        let path =
            if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
        let mut inner = Vec::new();
        match &field.base {
            Base::Message(name) => {
                let message = find(name).filter(|_| depth > 0).ok_or_else(|| name.clone())?;
                flatten(&message, find, &path, depth - 1, &mut inner)?;
                if message.fields.is_empty() {
                    // ROS encodes an empty message as one byte.
                    inner.push(Leaf { path: path.clone(), wire: Wire::Value(Base::UInt8) });
                }
            }
            base => inner.push(Leaf { path: path.clone(), wire: Wire::Value(plain(base)) }),
        }
        match field.shape {
            Shape::One => out.append(&mut inner),
            Shape::Array(count) => out.push(Leaf { path, wire: Wire::Array(count, inner) }),
            Shape::Sequence(_) => out.push(Leaf { path, wire: Wire::Sequence(inner) }),
        }
    }
    Ok(())
}

/// The type without what does not affect the encoding.
fn plain(base: &Base) -> Base {
    match base {
        Base::Byte => Base::UInt8,
        Base::String(_) => Base::String(None),
        Base::WString(_) => Base::WString(None),
        other => other.clone(),
    }
}

fn show(message: &Message, find: Find<'_>, depth: usize, out: &mut String) {
    if message.fields.is_empty() {
        _ = writeln!(out, "{:1$}nothing", "", 2 * depth);
    }
    for Field { name, base, shape, .. } in &message.fields {
        _ = writeln!(out, "{:1$}{base}{shape} {name}", "", 2 * depth);
        let inner = match base {
            Base::Message(name) if depth < 6 => find(name),
            _ => None,
        };
        if let Some(inner) = inner {
            show(&inner, find, depth + 1, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::Interface;
    use crate::{parse, standard};
    use expect_test::expect;

    fn message(text: &str) -> Message {
        match parse(&TypeName::new("demo", "msg", "Pose"), text) {
            Ok(Interface::Message(message)) => message,
            other => panic!("{other:?}"),
        }
    }

    fn told(text: &str, ros: &str) -> Result<(), String> {
        let theirs = standard::message(&TypeName::parse(ros).unwrap()).unwrap();
        let find = |name: &TypeName| standard::message(name);
        compare("::demo::pose", (&message(text), &find), (&theirs, &find))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn names_bounds_and_nesting_do_not_matter() {
        let flat = "float64 a\nfloat64 b\nfloat64 c\ngeometry_msgs/Quaternion d\n";
        assert_eq!(told(flat, "geometry_msgs/msg/Pose"), Ok(()));
        assert_eq!(told("string<=3 x\n", "std_msgs/msg/String"), Ok(()));
        assert_eq!(told("", "std_msgs/msg/Empty"), Ok(()));
    }

    #[test]
    fn what_differs_is_shown_both_ways() {
        expect![[r#"
            ::demo::pose and geometry_msgs/msg/Point differ at `y`, there `y`:
            ::demo::pose is
              float64 x
              float32 y
            geometry_msgs/msg/Point is
              float64 x
              float64 y
              float64 z"#]]
        .assert_eq(&told("float64 x\nfloat32 y\n", "geometry_msgs/msg/Point").unwrap_err());
        expect![[r#"
            ::demo::pose and geometry_msgs/msg/Polygon differ at `b`, which only ::demo::pose has:
            ::demo::pose is
              geometry_msgs/Point32[<=9] a
                float32 x
                float32 y
                float32 z
              bool b
            geometry_msgs/msg/Polygon is
              geometry_msgs/Point32[] points
                float32 x
                float32 y
                float32 z"#]]
        .assert_eq(
            &told("geometry_msgs/Point32[<=9] a\nbool b\n", "geometry_msgs/msg/Polygon")
                .unwrap_err(),
        );
    }
}
