//! The header of components with `lang "c++"` (genom3.md 6): namespaces, references, classes of the
//! standard library, abstract ports, exceptions that are thrown.

mod declare;
mod guard;
mod handle;
mod types;

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::model::{Codel, Component, Specification};
use genom_types::{Kind, TypeId, TypeTable};

use super::error::HeaderError;
use super::signatures::Signatures;
use super::{constant, order};
use guard::scoped;

/// Writes the header, after checking that all types have a mapping in C++.
pub(super) fn write(
    spec: &Specification,
    chosen: &[&Component],
    records: &HashSet<TypeId>,
    signatures: Signatures,
) -> Result<String, HeaderError> {
    let types = &spec.types;
    refuse(types, records)?;
    let names: Vec<_> = chosen.iter().map(|c| c.name.as_str()).collect();
    let guard = format!("H_{}_CXX_TYPES", names.join("_").to_uppercase());
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "/* Types and codels of {} in C++: made by genomd, do not edit. */\n\
         #ifndef {guard}\n#define {guard}\n\n\
         #include <cstdint>\n#include <string>\n#include <vector>\n\n\
         #include \"genom3/c++/event.h\"\n#include \"genom3/c++/exception.h\"\n\
         #include \"genom3/c++/idloptional.h\"\n#include \"genom3/c++/idlsequence.h\"\n\n",
        names.join(", ")
    );
    let scopes = types::scopes(types);
    for step in order::order(types, records) {
        match step {
            order::Step::Forward(id) => types::forward(&mut out, types, &scopes, id),
            order::Step::Define(id) => types::define(&mut out, types, &scopes, id),
        }
    }
    for one in &spec.constants {
        let value = constant::value_in(types, one.ty, &one.value, &declare::enumerator);
        let text = match types.resolved(one.ty) {
            Kind::String { .. } => {
                format!("static const std::string {} = {value};", one.name.last())
            }
            _ => {
                let declared = declare::declare(types, one.ty, one.name.last());
                format!("static const {declared} = {value};")
            }
        };
        scoped(&mut out, &one.name, &text);
    }
    for component in chosen {
        handle::events(&mut out, component);
        handle::ports(&mut out, types, component);
        handle::remotes(&mut out, types, component);
    }
    if signatures == Signatures::Written {
        handle::codels(&mut out, types, chosen);
    }
    let _ = writeln!(out, "#endif /* {guard} */");
    Ok(out)
}

/// The declaration of a codel in C++.
#[must_use]
pub fn prototype(types: &TypeTable, component: &Component, codel: &Codel) -> String {
    handle::prototype(types, component, codel)
}

/// A declaration in C++, such as `char name[8]`; of the type alone when `name` is empty.
#[must_use]
pub fn declaration(types: &TypeTable, ty: TypeId, name: &str) -> String {
    declare::declare(types, ty, name)
}

/// Refuses types without a mapping in C++ (genom3.md 6).
fn refuse(types: &TypeTable, records: &HashSet<TypeId>) -> Result<(), HeaderError> {
    for (id, kind) in types.iter().filter(|(id, _)| !records.contains(id)) {
        let why = match kind {
            Kind::Sequence { element, .. } => match types.resolved(*element) {
                Kind::Array { .. } | Kind::String { bound: Some(_) } => Some(format!(
                    "{} has no C++ type, because its elements are arrays: put the element in a \
                     struct",
                    types.spelling(id)
                )),
                _ => None,
            },
            Kind::Union { name, members, .. } => {
                let constructed = members.iter().find(|m| is_constructed(types, m.ty));
                constructed.map(|member| {
                    format!(
                        "member '{}' of type {} not allowed in C++ union {name}: put it beside \
                         the union",
                        member.name,
                        types.spelling(member.ty)
                    )
                })
            }
            _ => None,
        };
        if let Some(why) = why {
            return Err(HeaderError::Cxx { why });
        }
    }
    Ok(())
}

/// Whether a type has a constructor in C++: unbounded strings, sequences, and what contains one.
fn is_constructed(types: &TypeTable, id: TypeId) -> bool {
    match types.resolved(id) {
        Kind::String { bound: None } | Kind::Sequence { .. } => true,
        Kind::Array { element, .. } | Kind::Optional { element } => is_constructed(types, *element),
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
            members.iter().any(|member| is_constructed(types, member.ty))
        }
        _ => false,
    }
}
