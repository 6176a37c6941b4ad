//! C++ declarators (genom3.md 6).

use genom_types::{Kind, ScopedName, TypeId, TypeTable};

use super::super::declare::Passing;
use super::guard::namespace;

/// The name of a type, for use in a template or member; arrays have none of their own.
fn name(types: &TypeTable, id: TypeId) -> String {
    match types.kind(id) {
        Kind::String { bound: None } => "std::string".to_owned(),
        Kind::Sequence { element, bound } => {
            let element = name(types, *element);
            // `<:` would be read as a digraph for `[`.
            match bound {
                Some(bound) => format!("genom::bounded_sequence< {element}, {bound} >"),
                None => format!("std::vector< {element} >"),
            }
        }
        Kind::Optional { element } => {
            format!("genom::optional< {} >", declare(types, *element, "").trim_end())
        }
        Kind::Exception { name, .. } => format!("{}::detail", scoped(name)),
        Kind::Native { name } => format!("{} *", scoped(name)),
        kind => kind.name().map_or_else(|| types.c_name(id), scoped),
    }
}

/// `demo::state`.
pub(super) fn scoped(name: &ScopedName) -> String {
    name.segments().join("::")
}

/// The name of an enumerator, whose scope is that of its enum.
pub(super) fn enumerator(name: &ScopedName, short: &str) -> String {
    let scope = namespace(name);
    ScopedName::new(scope.iter().cloned()).join(short).segments().join("::")
}

/// A declaration of `declarator`, without its semicolon.
pub(super) fn declare(types: &TypeTable, id: TypeId, declarator: &str) -> String {
    match types.kind(id) {
        Kind::Array { element, length } => declare(types, *element, &indexed(declarator, *length)),
        Kind::String { bound: Some(bound) } => format!("char {}", indexed(declarator, *bound)),
        Kind::Native { name } => format!("{} *{declarator}", scoped(name)),
        _ if declarator.is_empty() => name(types, id),
        _ => format!("{} {declarator}", name(types, id)),
    }
}

fn indexed(declarator: &str, length: u32) -> String {
    format!("{declarator}[{length}]")
}

/// The declaration of a parameter: the type behind typedefs decides how it is passed, the declared
/// type how it is spelled.
pub(super) fn parameter(types: &TypeTable, id: TypeId, passing: Passing, name: &str) -> String {
    let input = passing == Passing::Value;
    let constant = if input { "const " } else { "" };
    match types.resolved(id) {
        Kind::String { bound: Some(_) } | Kind::Array { .. } => {
            format!("{constant}{}", declare(types, id, name))
        }
        // The pointer belongs to the host, what it points to belongs to the codels.
        Kind::Native { name: native } if input => format!("const {} *{name}", scoped(native)),
        Kind::String { bound: None }
        | Kind::Sequence { .. }
        | Kind::Optional { .. }
        | Kind::Struct { .. }
        | Kind::Union { .. }
        | Kind::Exception { .. } => {
            format!("{constant}{}", declare(types, id, &format!("&{name}")))
        }
        _ if input => declare(types, id, name),
        _ => declare(types, id, &format!("&{name}")),
    }
}
