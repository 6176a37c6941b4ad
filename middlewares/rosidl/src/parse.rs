//! Parses `.msg`, `.srv` and `.action` text.
//!
//! Parses only what affects the encoding: default values and comments are skipped.

use crate::interface::{Action, Base, Constant, Field, Interface, Message, Service, Shape};
use crate::names::TypeName;

/// A text does not define an interface.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}, line {line}: {why}")]
pub struct ParseError {
    /// Name of the interface.
    pub name: TypeName,
    /// Line number, from 1.
    pub line: usize,
    /// What is wrong there.
    pub why: Mistake,
}

/// What is wrong with a line, or with the number of parts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Mistake {
    /// A field or constant without a name.
    #[error("`{0}` has no name")]
    NoName(String),
    /// Neither a built-in type nor the name of a message.
    #[error("`{0}` is no type")]
    NoType(String),
    /// A bound or a length that is not a number.
    #[error("`{0}` is no size")]
    NoSize(String),
    /// A line `---` after the last part that is allowed.
    #[error("a {0} has no more parts")]
    MoreParts(String),
    /// Too few parts.
    #[error("it has {found} parts, a {folder} has {wanted}")]
    Parts {
        /// Number of parts in the text.
        found: usize,
        /// `msg`, `srv` or `action`.
        folder: String,
        /// Number of parts that such an interface has.
        wanted: usize,
    },
}

/// Parses the text of an interface. `name` determines its kind.
///
/// # Errors
/// A line is neither a field nor a constant, or there are too many or too few parts.
pub fn parse(name: &TypeName, text: &str) -> Result<Interface, ParseError> {
    let suffixes: &[&str] = match name.folder.as_str() {
        "srv" => &["_Request", "_Response"],
        "action" => &["_Goal", "_Result", "_Feedback"],
        _ => &[""],
    };
    let error = |line: usize, why: Mistake| ParseError { name: name.clone(), line, why };
    let mut parts = vec![Message::new(name.part(suffixes.first().copied().unwrap_or_default()))];
    for (at, line) in text.lines().enumerate() {
        let code = line.split('#').next().unwrap_or_default().trim();
        if code == "---" {
            let Some(suffix) = suffixes.get(parts.len()) else {
                return Err(error(at + 1, Mistake::MoreParts(name.folder.clone())));
            };
            parts.push(Message::new(name.part(suffix)));
            continue;
        }
        if code.is_empty() {
            continue;
        }
        let part = parts.last_mut();
        let read = part.map_or(Ok(()), |part| member(part, &name.package, code, line));
        read.map_err(|why| error(at + 1, why))?;
    }
    if parts.len() != suffixes.len() {
        let (found, wanted) = (parts.len(), suffixes.len());
        let why = Mistake::Parts { found, folder: name.folder.clone(), wanted };
        return Err(error(text.lines().count().max(1), why));
    }
    let mut parts = parts.into_iter();
    let name = name.clone();
    Ok(match (parts.next(), parts.next(), parts.next()) {
        (Some(goal), Some(result), Some(feedback)) => {
            Interface::Action(Action { name, goal, result, feedback })
        }
        (Some(request), Some(response), None) => {
            Interface::Service(Service { name, request, response })
        }
        (message, ..) => Interface::Message(message.unwrap_or_else(|| Message::new(name))),
    })
}

/// Parses one field or constant.
fn member(to: &mut Message, package: &str, code: &str, line: &str) -> Result<(), Mistake> {
    let no_name = || Mistake::NoName(code.to_owned());
    let (ty, rest) = code.split_once(char::is_whitespace).ok_or_else(no_name)?;
    let (base, shape) = field_type(ty, package)?;
    let rest = rest.trim_start();
    let name: String =
        rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
    if name.is_empty() {
        return Err(no_name());
    }
    let after = rest.get(name.len()..).unwrap_or_default().trim_start();
    if after.starts_with('=') {
        // In a string constant, `#` does not begin a comment.
        let whole = if matches!(base, Base::String(_)) { line } else { code };
        let value = whole.split_once('=').map_or("", |(_, value)| value).trim().to_owned();
        to.constants.push(Constant { name, base, value });
    } else {
        to.fields.push(Field { name, base, shape, comment: None });
    }
    Ok(())
}

fn field_type(text: &str, package: &str) -> Result<(Base, Shape), Mistake> {
    let number = |text: &str| text.parse::<u32>().map_err(|_| Mistake::NoSize(text.to_owned()));
    let (element, shape) = match text.strip_suffix(']').and_then(|text| text.rsplit_once('[')) {
        None => (text, Shape::One),
        Some((element, "")) => (element, Shape::Sequence(None)),
        Some((element, size)) => match size.strip_prefix("<=") {
            Some(most) => (element, Shape::Sequence(Some(number(most)?))),
            None => (element, Shape::Array(number(size)?)),
        },
    };
    let (word, bound) = match element.split_once("<=") {
        Some((word, most)) => (word, Some(number(most)?)),
        None => (element, None),
    };
    let base = match word {
        "bool" => Base::Bool,
        "byte" => Base::Byte,
        "char" | "uint8" => Base::UInt8,
        "int8" => Base::Int8,
        "int16" => Base::Int16,
        "uint16" => Base::UInt16,
        "int32" => Base::Int32,
        "uint32" => Base::UInt32,
        "int64" => Base::Int64,
        "uint64" => Base::UInt64,
        "float32" => Base::Float32,
        "float64" => Base::Float64,
        "string" => Base::String(bound),
        "wstring" => Base::WString(bound),
        // The only message that ROS allows without its package.
        "Header" => Base::Message(TypeName::new("std_msgs", "msg", "Header")),
        other => {
            let full = match other.split('/').collect::<Vec<_>>()[..] {
                [name] => format!("{package}/msg/{name}"),
                [package, name] => format!("{package}/msg/{name}"),
                _ => other.to_owned(),
            };
            let name = TypeName::parse(&full).ok_or_else(|| Mistake::NoType(other.to_owned()))?;
            Base::Message(name)
        }
    };
    Ok((base, shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let text =
            "uint8 A=1\nstring B=x # y\nint8[] a\nstring<=4[<=2] b\ngeometry_msgs/Pose[3] c\n";
        let name = TypeName::new("demo", "msg", "State");
        assert_eq!(parse(&name, text).unwrap().to_string(), text);
        let name = TypeName::new("demo", "action", "Go");
        let read = parse(&name, "# goal\nPose p 1.0\n---\n---\nHeader h\n").unwrap();
        assert_eq!(read.to_string(), "demo/Pose p\n---\n---\nstd_msgs/Header h\n");
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let told = |folder: &str, text: &str| {
            parse(&TypeName::new("p", folder, "T"), text).unwrap_err().to_string()
        };
        assert_eq!(told("msg", "int8 a\nint8"), "p/msg/T, line 2: `int8` has no name");
        assert_eq!(told("msg", "int8[x] a"), "p/msg/T, line 1: `x` is no size");
        assert_eq!(told("msg", "---"), "p/msg/T, line 1: a msg has no more parts");
        assert_eq!(told("srv", "int8 a\n"), "p/srv/T, line 1: it has 1 parts, a srv has 2");
    }
}
