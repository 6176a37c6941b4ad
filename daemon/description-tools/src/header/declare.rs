//! C declarators: members, parameters and results (genom3.md 5.2, 5.5).

use genom_description::c_names::is_taken;
use genom_types::{Kind, TypeId, TypeTable};

/// How an argument is passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passing {
    Value,
    Reference,
}

/// A declaration of `declarator`, without its semicolon: `double x[2]`, `char *x`.
pub(super) fn declare(types: &TypeTable, id: TypeId, declarator: &str) -> String {
    let joined = |name: &str| {
        if declarator.is_empty() { name.to_owned() } else { format!("{name} {declarator}") }
    };
    match types.kind(id) {
        Kind::Array { element, length } => declare(types, *element, &indexed(declarator, *length)),
        Kind::String { bound: Some(bound) } => format!("char {}", indexed(declarator, *bound)),
        Kind::String { bound: None } => format!("char *{declarator}"),
        Kind::Native { name } => format!("{} *{declarator}", name.to_c()),
        _ => joined(&types.c_name(id)),
    }
}

fn indexed(declarator: &str, length: u32) -> String {
    if declarator.starts_with('*') {
        format!("({declarator})[{length}]")
    } else {
        format!("{declarator}[{length}]")
    }
}

/// The declaration of a parameter. The type behind typedefs decides how it is passed, the declared
/// type how it is spelled.
pub(super) fn parameter(types: &TypeTable, id: TypeId, passing: Passing, name: &str) -> String {
    let pointer = format!("*{name}");
    match (types.resolved(id), passing) {
        (Kind::String { bound: Some(_) } | Kind::Array { .. }, Passing::Value) => {
            format!("const {}", declare(types, id, name))
        }
        (Kind::String { bound: Some(_) } | Kind::Array { .. }, Passing::Reference) => {
            declare(types, id, name)
        }
        // Strings and natives are pointers already, also behind a typedef.
        (Kind::String { bound: None } | Kind::Native { .. }, Passing::Value) => {
            format!("const {}", declare(types, id, name))
        }
        (
            Kind::Sequence { .. }
            | Kind::Optional { .. }
            | Kind::Struct { .. }
            | Kind::Union { .. }
            | Kind::Exception { .. },
            Passing::Value,
        ) => format!("const {}", declare(types, id, &pointer)),
        (_, Passing::Value) => declare(types, id, name),
        (_, Passing::Reference) => declare(types, id, &pointer),
    }
}

/// The method of a port that gives the address of its data (genom3.md 5.7).
pub(super) fn data_method(types: &TypeTable, id: TypeId, arguments: &str) -> String {
    match types.resolved(id) {
        Kind::String { bound: Some(_) } => format!("char *(*data)({arguments})"),
        // GenoM3 writes invalid C for several dimensions: a pointer to the inner array is meant.
        Kind::Array { element, .. } => declare(types, *element, &format!("*(*data)({arguments})")),
        _ => declare(types, id, &format!("*(*data)({arguments})")),
    }
}

/// A valid name for a parameter: keywords of C and C++ get a final `_`, and so does `self`.
pub(super) fn argument(name: &str) -> String {
    if is_taken(name) || name == "self" { format!("{name}_") } else { name.to_owned() }
}
