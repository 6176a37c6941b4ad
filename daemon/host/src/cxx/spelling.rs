//! C++ declarations as the demangler writes them, by which the function of a codel is recognised in
//! a library (genom3.md 6).

use genom_description::model::{Codel, CodelParameter, Component, Direction, Source};
use genom_types::{Kind, ScopedName, TypeId, TypeTable};

/// Deepest nesting that is spelled out: a type may contain itself.
const DEEPEST: usize = 128;

/// `f(int, demo::s const&)`, without insignificant blanks.
pub(crate) fn codel(component: &Component, types: &TypeTable, codel: &Codel) -> String {
    let parameters = codel.parameters.iter();
    let parameters: Vec<_> = parameters.map(|p| parameter(component, types, p)).collect();
    compact(&format!("{}({})", codel.name, parameters.join(",")))
}

fn parameter(component: &Component, types: &TypeTable, parameter: &CodelParameter) -> String {
    let object = match parameter.source {
        Source::Port(port) => component.ports.get(port).map(|port| &port.name),
        Source::Remote(remote) => component.remotes.get(remote).map(|remote| &remote.name),
        _ => return datum(types, parameter.ty, parameter.direction),
    };
    format!("{}::{}&", component.name, object.map_or("?", String::as_str))
}

/// How a datum is passed.
pub(super) fn datum(types: &TypeTable, ty: TypeId, direction: Direction) -> String {
    let input = direction == Direction::In;
    let constant = if input { " const" } else { "" };
    let spelled = spell(types, ty, DEEPEST);
    match types.resolved(ty) {
        Kind::Array { element, .. } => {
            let (inner, dimensions) = dimensions(types, *element);
            let inner = spell(types, inner, DEEPEST);
            let inner = inner.split('[').next().unwrap_or_default().trim_end().to_owned();
            match dimensions.is_empty() {
                true => format!("{inner}{constant}*"),
                false => format!("{inner}{constant}(*){dimensions}"),
            }
        }
        Kind::String { bound: Some(_) } => format!("char{constant}*"),
        Kind::Native { name } if input => format!("{} const*", scoped(name)),
        Kind::Native { name } => format!("{}*&", scoped(name)),
        Kind::String { .. }
        | Kind::Sequence { .. }
        | Kind::Optional { .. }
        | Kind::Struct { .. }
        | Kind::Union { .. }
        | Kind::Exception { .. } => format!("{spelled}{constant}&"),
        _ if input => spelled,
        _ => format!("{spelled}&"),
    }
}

/// The element of an array of arrays, and all dimensions: bounded strings are arrays too.
fn dimensions(types: &TypeTable, ty: TypeId) -> (TypeId, String) {
    match types.resolved(ty) {
        Kind::Array { element, length } => {
            let (inner, rest) = dimensions(types, *element);
            (inner, format!("[{length}]{rest}"))
        }
        Kind::String { bound: Some(bound) } => (ty, format!("[{bound}]")),
        _ => (ty, String::new()),
    }
}

/// A type as it is spelled as a template argument.
fn spell(types: &TypeTable, ty: TypeId, depth: usize) -> String {
    if depth == 0 {
        return "...".to_owned();
    }
    let inner = |ty: &TypeId| spell(types, *ty, depth - 1);
    match types.resolved(ty) {
        Kind::Boolean => "bool".to_owned(),
        Kind::Char => "signed char".to_owned(),
        Kind::Octet => "unsigned char".to_owned(),
        Kind::Short => "short".to_owned(),
        Kind::UnsignedShort => "unsigned short".to_owned(),
        Kind::Long => "int".to_owned(),
        Kind::UnsignedLong => "unsigned int".to_owned(),
        // int64_t is `long` on 64-bit Linux.
        Kind::LongLong => "long".to_owned(),
        Kind::UnsignedLongLong => "unsigned long".to_owned(),
        Kind::Float => "float".to_owned(),
        Kind::Double => "double".to_owned(),
        Kind::String { bound: None } => {
            "std::__cxx11::basic_string<char,std::char_traits<char>,std::allocator<char>>"
                .to_owned()
        }
        Kind::String { bound: Some(bound) } => format!("char[{bound}]"),
        Kind::Array { element, length } => {
            let (element, rest) = dimensions(types, *element);
            let element = spell(types, element, depth - 1);
            let element = element.split('[').next().unwrap_or_default().to_owned();
            format!("{element}[{length}]{rest}")
        }
        Kind::Sequence { element, bound: None } => {
            let element = inner(element);
            format!("std::vector<{element},std::allocator<{element}>>")
        }
        Kind::Sequence { element, bound: Some(bound) } => {
            format!("genom::bounded_sequence<{},{bound}>", inner(element))
        }
        Kind::Optional { element } => format!("genom::optional<{}>", inner(element)),
        Kind::Native { name } => format!("{}*", scoped(name)),
        Kind::Exception { name, .. } => format!("{}::detail", scoped(name)),
        kind => kind.name().map_or_else(|| kind.keyword().to_owned(), scoped),
    }
}

fn scoped(name: &ScopedName) -> String {
    name.segments().join("::")
}

/// The demangler's text without insignificant blanks and without suffixes of numbers.
pub(crate) fn compact(text: &str) -> String {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut chars = text.chars().peekable();
    // Whether the last characters form a number.
    let mut number = false;
    while let Some(c) = chars.next() {
        if c == ' ' {
            let between =
                out.chars().last().is_some_and(word) && chars.peek().copied().is_some_and(word);
            if between {
                out.push(c);
            }
            number = false;
        } else if number && (c == 'u' || c == 'l') {
        } else {
            let starts = !out.chars().last().is_some_and(word);
            number = c.is_ascii_digit() && (number || starts);
            out.push(c);
        }
    }
    out
}

/// The name of the type of exceptions `name`, as in `std::type_info`.
pub(super) fn type_info(name: &str) -> String {
    let segments: Vec<&str> = name.split("::").filter(|segment| !segment.is_empty()).collect();
    let encoded: String =
        segments.iter().map(|segment| format!("{}{segment}", segment.len())).collect();
    if segments.len() == 1 { encoded } else { format!("N{encoded}E") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_and_suffixes_of_numbers_go_and_words_stay_apart() {
        let long = "f(unsigned int, char const*, genom::bounded_sequence<u8l, 4ul>&, int (*) [3])";
        let short = "f(unsigned int,char const*,genom::bounded_sequence<u8l,4>&,int(*)[3])";
        assert_eq!(compact(long), short);
        assert_eq!(compact(short), short);
    }

    #[test]
    fn a_type_info_is_named_as_the_compiler_does() {
        assert_eq!(type_info("::demo::OUT_OF_RANGE"), "N4demo12OUT_OF_RANGEE");
        assert_eq!(type_info("::top"), "3top");
    }
}
