//! The C definition of each type (genom3.md 5.2).

use std::collections::HashSet;
use std::fmt::Write;

use genom_types::{Kind, Member, ScopedName, TypeId, TypeTable};

use super::declare::declare;
use super::guard::guarded;

/// Forward declaration of a struct that a sequence needs before it is complete.
pub(super) fn forward(out: &mut String, types: &TypeTable, id: TypeId) {
    let name = types.c_name(id);
    let text = format!("typedef struct {name} {name};");
    guarded(out, &format!("{name}_forward"), &text);
}

/// Defines a type under its own guard; `constructed` are the types with constructors in C++.
pub(super) fn define(
    out: &mut String,
    types: &TypeTable,
    id: TypeId,
    constructed: &mut HashSet<TypeId>,
) {
    if has_constructor(types, id, constructed) {
        constructed.insert(id);
    }
    let tag = types.c_name(id);
    match types.kind(id) {
        Kind::Enum { name, enumerators } => {
            let list: Vec<_> = (0..)
                .zip(enumerators)
                .map(|(rank, short): (u32, _)| format!("  {} = {rank}", enumerator(name, short)))
                .collect();
            let text = format!("typedef uint32_t {tag};\nenum {{\n{}\n}};", list.join(",\n"));
            guarded(out, &tag, &text);
        }
        Kind::Struct { members, .. } => structure(out, &tag, &tag, &lines(types, members)),
        Kind::Exception { name, members } => exception(out, types, name, members),
        Kind::Union { discriminant, members, .. } => {
            let inner = format!("{tag}_members");
            // In C++, members with constructors delete those of the union; it needs a name so that
            // new ones can be defined.
            let special = members.iter().any(|member| constructed.contains(&member.ty));
            let name = if special { format!("{inner} ") } else { String::new() };
            let mut body =
                format!("  {};\n  union {name}{{\n", declare(types, *discriminant, "_d"));
            for member in members {
                let _ = writeln!(body, "    {};", declare(types, member.ty, &member.name));
            }
            if special {
                body.push_str(&bytewise(&inner));
            }
            body.push_str("  } _u;\n");
            structure(out, &tag, &tag, &body);
        }
        Kind::Sequence { element, bound: None } => {
            let buffer = declare(types, *element, "*_buffer");
            let body = format!(
                "  uint32_t _maximum, _length;\n  {buffer};\n  void (*_release)(void *_buffer);\n"
            );
            structure(out, &tag, &tag, &body);
        }
        Kind::Sequence { element, bound: Some(bound) } => {
            let buffer = declare(types, *element, &format!("_buffer[{bound}]"));
            structure(out, &tag, &tag, &bounded(&tag, &buffer, *bound));
        }
        Kind::Optional { element } => {
            let value = declare(types, *element, "_value");
            structure(out, &tag, &tag, &format!("  bool _present;\n  {value};\n"));
        }
        Kind::Native { name } => {
            let name = name.to_c();
            guarded(out, &name, &format!("typedef struct {name} {name};"));
        }
        Kind::Typedef { name, target } => {
            let name = name.to_c();
            let text = format!("typedef {};", declare(types, *target, &name));
            guarded(out, &name, &text);
        }
        _ => {}
    }
}

/// The C name of an enumerator, whose scope is that of its enum (genom3.md 4.2).
pub(super) fn enumerator(name: &ScopedName, short: &str) -> String {
    let segments = name.segments();
    let scope = segments.get(..segments.len().saturating_sub(1)).unwrap_or_default();
    ScopedName::new(scope.iter().cloned()).join(short).to_c()
}

fn lines(types: &TypeTable, members: &[Member]) -> String {
    members.iter().map(|m| format!("  {};\n", declare(types, m.ty, &m.name))).collect()
}

/// `struct X { ... }; typedef struct X X;`: valid after a forward declaration in C99 too, where a
/// typedef may not be repeated.
fn structure(out: &mut String, guard: &str, tag: &str, body: &str) {
    let text = format!(
        "struct {tag} {{\n{body}}};\n\
         #ifndef _{tag}_forward_c_type\n# define _{tag}_forward_c_type\n\
         typedef struct {tag} {tag};\n#endif"
    );
    guarded(out, guard, &text);
}

/// Constructors and assignment of a union whose members have their own: they copy all bytes, as C
/// does.
fn bytewise(tag: &str) -> String {
    format!(
        "#ifdef __cplusplus\n\
         \x20   {tag}() {{ memset((void *)this, 0, sizeof(*this)); }}\n\
         \x20   {tag}(const {tag} &from) {{ *this = from; }}\n\
         \x20   {tag} &operator=(const {tag} &from) {{\n\
         \x20     memcpy((void *)this, (const void *)&from, sizeof(*this));\n\
         \x20     return *this;\n\
         \x20   }}\n\
         #endif\n"
    )
}

/// Whether a type has constructors in C++: bounded sequences, and what contains one.
fn has_constructor(types: &TypeTable, id: TypeId, constructed: &HashSet<TypeId>) -> bool {
    let any = |members: &[Member]| members.iter().any(|member| constructed.contains(&member.ty));
    match types.kind(id) {
        Kind::Sequence { bound, .. } => bound.is_some(),
        Kind::Array { element, .. } | Kind::Optional { element } => constructed.contains(element),
        Kind::Typedef { target, .. } => constructed.contains(target),
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => any(members),
        Kind::Union { members, .. } => members.iter().any(|m| constructed.contains(&m.ty)),
        _ => false,
    }
}

/// Members of a bounded sequence. `_maximum` is not const, since codels assign whole structs that
/// contain one (genom3.md D); code written for a const one compiles too. In C++ it is initialised
/// in a way that keeps aggregate initialisation where the standard allows both.
fn bounded(tag: &str, buffer: &str, bound: u32) -> String {
    format!(
        "#if defined(__cplusplus) && __cplusplus >= 201402L\n\
         \x20 uint32_t _maximum = {bound}, _length = 0;\n\
         #else\n\
         \x20 uint32_t _maximum, _length;\n\
         #endif\n\
         \x20 {buffer};\n\
         #if defined(__cplusplus) && __cplusplus < 201402L\n\
         \x20 {tag}() : _maximum({bound}), _length(0) {{}}\n\
         #endif\n"
    )
}

/// An exception: its event, its detail, and the function that throws it (genom3.md 5.4).
fn exception(out: &mut String, types: &TypeTable, name: &ScopedName, members: &[Member]) {
    let c = name.to_c();
    let event = format!("GENOM_EVENT({c}_id, \"{name}\");\n");
    let text = if members.is_empty() {
        format!(
            "{event}typedef void {c}_detail;\n\n\
             static inline genom_event\n{c}(genom_context self)\n{{\n\
             \x20 return self->raise({c}_id, NULL, 0, self);\n}}"
        )
    } else {
        let body = lines(types, members);
        format!(
            "{event}typedef struct {c}_detail {{\n{body}}} {c}_detail;\n\n\
             static inline genom_event\n{c}(const {c}_detail *detail, genom_context self)\n{{\n\
             \x20 return self->raise({c}_id, detail, sizeof(*detail), self);\n}}"
        )
    };
    guarded(out, &c, &text);
}
