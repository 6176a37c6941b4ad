//! The header that codels are compiled against (genom3.md 5): types, events, exceptions, ports,
//! remotes and prototypes. It is not needed at run time.
//!
//! Existing component sources use these names and layouts, so none may change.

mod constant;
mod cxx;
mod declare;
mod error;
mod guard;
mod handle;
mod order;
mod python;
mod rust;
mod signatures;
mod types;

pub use cxx::{declaration, prototype};
pub use error::HeaderError;
pub use signatures::Signatures;

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::c_names::{clashes, records};
use genom_description::model::{Codel, Component, Specification};
use genom_types::{Kind, TypeId, TypeTable};

/// Languages that headers are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// C++11: with the C interface, or for components of `lang "c++"` that of genom3.md 6.
    Cxx,
    /// Rust, for plain `extern "C"` codels.
    Rust,
    /// Python: a stub of the types, for editors.
    Python,
}

/// The header of one component, or of all, with the prototypes of codels.
///
/// # Errors
/// When there is no such component, or when a type has no mapping.
pub fn header(
    spec: &Specification,
    component: Option<&str>,
    language: Language,
) -> Result<String, HeaderError> {
    mappings(spec, component, language, Signatures::Written)
}

/// The header of one component, or of all.
///
/// # Errors
/// As for [`header`].
pub fn mappings(
    spec: &Specification,
    component: Option<&str>,
    language: Language,
    signatures: Signatures,
) -> Result<String, HeaderError> {
    let chosen: Vec<&Component> =
        spec.components.iter().filter(|c| component.is_none_or(|name| c.name == name)).collect();
    if let Some(name) = component
        && chosen.is_empty()
    {
        let known: Vec<_> = spec.components.iter().map(|c| format!("`{}`", c.name)).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        return Err(HeaderError::NoComponent { name: name.to_owned(), known });
    }
    refuse_any(&spec.types)?;
    let records = records(spec);
    if let Some((name, one, other)) =
        clashes(&spec.types, &spec.constants, chosen.iter().copied(), &records).into_iter().next()
    {
        return Err(HeaderError::Clash { name, one: one.idl, other: other.idl });
    }
    match language {
        Language::Rust => Ok(rust::write(spec, &chosen, &records)),
        Language::Python => Ok(python::write(spec, &chosen, &records)),
        Language::Cxx if chosen.iter().any(|c| c.lang == "c++") => {
            if let [Some(cxx), Some(c)] =
                [true, false].map(|cxx| chosen.iter().find(|c| (c.lang == "c++") == cxx))
            {
                return Err(HeaderError::Mixed { cxx: cxx.name.clone(), c: c.name.clone() });
            }
            cxx::write(spec, &chosen, &records, signatures)
        }
        Language::C | Language::Cxx => Ok(c(spec, &chosen, &records, language, signatures)),
    }
}

/// The declaration of a codel in the language of its component's interface, without semicolon:
/// `genom_event f(int32_t a, const genom_context self)`.
#[must_use]
pub fn signature(types: &TypeTable, component: &Component, codel: &Codel) -> String {
    if component.lang == "c++" {
        cxx::prototype(types, component, codel)
    } else {
        handle::prototype(types, component, codel)
    }
}

fn c(
    spec: &Specification,
    chosen: &[&Component],
    records: &HashSet<TypeId>,
    language: Language,
    signatures: Signatures,
) -> String {
    let names: Vec<_> = chosen.iter().map(|c| c.name.as_str()).collect();
    let title = if names.is_empty() { "genom".to_owned() } else { names.join("_") };
    let guard = format!("H_{}_C_TYPES", title.to_uppercase());
    let mut out = String::new();
    let what = if language == Language::Cxx { "C++, with the C interface" } else { "C" };
    let shown = if names.is_empty() { "the types".to_owned() } else { names.join(", ") };
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "/* Types and codels of {shown} in {what}: made by genomd, do not edit. */\n\
         #ifndef {guard}\n#define {guard}\n\n\
         #include <stdbool.h>\n#include <stdint.h>\n#include <string.h>\n\n\
         #include \"genom3/c/event.h\"\n#include \"genom3/c/context.h\"\n\
         #include \"genom3/c/exception.h\"\n#include \"genom3/c/idlsequence.h\"\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n"
    );
    let mut constructed = HashSet::new();
    for step in order::order(&spec.types, records) {
        match step {
            order::Step::Forward(id) => types::forward(&mut out, &spec.types, id),
            order::Step::Define(id) => {
                types::define(&mut out, &spec.types, id, &mut constructed);
            }
        }
    }
    for one in &spec.constants {
        constant::define(&mut out, &spec.types, one);
    }
    for component in chosen {
        handle::events(&mut out, component);
        handle::ports(&mut out, &spec.types, component);
        handle::remotes(&mut out, &spec.types, component);
    }
    if signatures == Signatures::Written {
        handle::codels(&mut out, &spec.types, chosen);
    }
    let _ = write!(out, "#ifdef __cplusplus\n}}\n#endif\n\n#endif /* {guard} */\n");
    out
}

fn refuse_any(types: &TypeTable) -> Result<(), HeaderError> {
    let is_any = |id: TypeId| matches!(types.resolved(id), Kind::Any);
    for (_, kind) in types.iter() {
        let inside = match kind {
            Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                members.iter().any(|member| is_any(member.ty))
            }
            Kind::Union { members, .. } => members.iter().any(|member| is_any(member.ty)),
            Kind::Typedef { target, .. } => is_any(*target),
            _ => false,
        };
        if inside {
            let name = kind.name().map(ToString::to_string).unwrap_or_default();
            return Err(HeaderError::Any { name });
        }
    }
    Ok(())
}
