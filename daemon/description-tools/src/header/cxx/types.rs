//! The C++ definition of each type (genom3.md 6).

use std::collections::HashMap;

use genom_types::{Kind, Member, ScopedName, TypeId, TypeTable};

use super::declare::declare;
use super::guard::{guarded, namespace, scoped};

/// Types that are defined inside a struct, union or exception, by its full name.
pub(super) type Scopes = HashMap<Vec<String>, Vec<TypeId>>;

/// Finds the types that are defined inside others.
pub(super) fn scopes(types: &TypeTable) -> Scopes {
    let mut scopes = Scopes::new();
    for (_, kind) in types.iter() {
        if let Kind::Struct { name, .. } | Kind::Union { name, .. } | Kind::Exception { name, .. } =
            kind
        {
            scopes.entry(name.segments().to_vec()).or_default();
        }
    }
    for (id, kind) in types.iter() {
        if let Some(name) = kind.name()
            && !matches!(kind, Kind::Forward { .. })
            && let Some(inside) = scopes.get_mut(namespace(name))
        {
            inside.push(id);
        }
    }
    scopes
}

fn is_nested(scopes: &Scopes, name: &ScopedName) -> bool {
    scopes.contains_key(namespace(name))
}

/// Forward declaration of a struct that a sequence needs before it is complete.
pub(super) fn forward(out: &mut String, types: &TypeTable, scopes: &Scopes, id: TypeId) {
    if let Some(name) = types.kind(id).name().filter(|name| !is_nested(scopes, name)) {
        let text = format!("struct {};", name.last());
        guarded(out, &format!("{}_forward", name.to_c()), namespace(name), &text);
    }
}

/// Defines a type, including those defined inside it.
pub(super) fn define(out: &mut String, types: &TypeTable, scopes: &Scopes, id: TypeId) {
    let Some(name) = types.kind(id).name().filter(|name| !is_nested(scopes, name)) else { return };
    if let Some(text) = definition(types, scopes, id) {
        scoped(out, name, &text);
    }
}

fn definition(types: &TypeTable, scopes: &Scopes, id: TypeId) -> Option<String> {
    let kind = types.kind(id);
    let name = kind.name()?;
    let short = name.last();
    let inside = scopes.get(name.segments()).into_iter().flatten();
    let inside = inside.filter_map(|id| definition(types, scopes, *id));
    let inside: String = inside.map(|text| indented(&text)).collect();
    Some(match kind {
        Kind::Enum { enumerators, .. } => {
            let ranks =
                (0_u32..).zip(enumerators).map(|(rank, one)| format!("  {one} = {rank},\n"));
            let ranks: String = ranks.collect();
            format!("enum {short} {{\n{ranks}  genom_max_{short} = 0xffffffff\n}};")
        }
        Kind::Struct { members, .. } => {
            format!("struct {short} {{\n{inside}{}}};", lines(types, members, "  "))
        }
        Kind::Union { discriminant, members, .. } => {
            let members = members.iter();
            let members = members.map(|m| format!("    {};\n", declare(types, m.ty, &m.name)));
            let discriminant = declare(types, *discriminant, "_d");
            format!(
                "struct {short} {{\n{inside}  {discriminant};\n  union {{\n{}  }} _u;\n}};",
                members.collect::<String>()
            )
        }
        Kind::Exception { name, members } => exception(types, name, members, &inside),
        Kind::Native { .. } => format!("struct {short};"),
        Kind::Typedef { target, .. } => format!("typedef {};", declare(types, *target, short)),
        _ => return None,
    })
}

fn lines(types: &TypeTable, members: &[Member], indent: &str) -> String {
    members.iter().map(|m| format!("{indent}{};\n", declare(types, m.ty, &m.name))).collect()
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

/// An exception: its event, and the struct that is thrown. `what()` is const, so that it overrides
/// that of `std::exception`; in GenoM3's own header it hides it.
fn exception(types: &TypeTable, name: &ScopedName, members: &[Member], inside: &str) -> String {
    let short = name.last();
    let body = if members.is_empty() {
        "  typedef void detail;\n".to_owned()
    } else {
        format!(
            "  struct detail {{\n{}  }} detail;\n\n\
             \x20 {short}(): detail() {{}}\n\
             \x20 explicit {short}(const struct detail &d): detail(d) {{}}\n",
            lines(types, members, "    ")
        )
    };
    format!(
        "GENOM_CXX_EVENT({short}_id, \"{name}\");\n\
         struct __attribute__((visibility(\"default\"))) {short} : public genom::exception {{\n\
         {inside}{body}  const char *what() const {{ return {short}_id; }}\n}};"
    )
}
