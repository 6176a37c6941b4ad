//! The same interface in Rust: `#[repr(C)]` types, events, handles and codel prototypes.
//!
//! It links no library. Components written for genomd use the `genom` crate instead, which is safe.

use std::collections::HashSet;
use std::fmt::Write;

use genom_description::c_names::event_names;
use genom_description::model::{Codel, Component, Parameter, PortDirection, Source, Specification};
use genom_types::{Kind, Member, TypeId, TypeTable};
use serde_json::Value;

use super::declare::Passing;
use super::{handle, order};

const PRELUDE: &str = "\
#![allow(non_camel_case_types, non_upper_case_globals, non_snake_case, dead_code)]

use core::ffi::{CStr, c_char, c_void};

/// Address of the NUL-terminated name of an event; null is `genom_ok`.
pub type genom_event = *const c_char;
/// Context of a codel, its last argument.
pub type genom_context = *const genom_context_iface;

#[repr(C)]
pub struct genom_context_iface {
    pub raise: unsafe extern \"C\" fn(genom_event, *const c_void, usize, genom_context) -> genom_event,
    pub raised: unsafe extern \"C\" fn(*mut genom_event, genom_context) -> *const c_void,
    pub data: *mut c_void,
}
";

pub(super) fn write(
    spec: &Specification,
    chosen: &[&Component],
    records: &HashSet<TypeId>,
) -> String {
    let names: Vec<_> = chosen.iter().map(|c| c.name.as_str()).collect();
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ =
        writeln!(out, "// Types and codels of {}: made by genomd, do not edit.", names.join(", "));
    out.push_str(PRELUDE);
    for step in order::order(&spec.types, records) {
        if let order::Step::Define(id) = step {
            define(&mut out, &spec.types, id);
        }
    }
    for one in &spec.constants {
        let name = word(&one.name.to_c());
        if let Some((ty, value)) = constant(&spec.types, one.ty, &one.value) {
            let _ = writeln!(out, "\npub const {name}: {ty} = {value};");
        }
    }
    let mut written = HashSet::new();
    for component in chosen {
        events(&mut out, component);
        handles(&mut out, &spec.types, component);
        for codel in component.codels.iter().filter(|c| !handle::is_standard(component, c)) {
            if written.insert(codel.name.as_str()) {
                prototype(&mut out, &spec.types, component, codel);
            }
        }
    }
    out
}

fn define(out: &mut String, types: &TypeTable, id: TypeId) {
    let tag = word(&types.c_name(id));
    match types.kind(id) {
        Kind::Enum { name, enumerators } => {
            let _ = writeln!(out, "\npub type {tag} = u32;");
            for (rank, short) in enumerators.iter().enumerate() {
                let short = word(&super::types::enumerator(name, short));
                let _ = writeln!(out, "pub const {short}: {tag} = {rank};");
            }
        }
        Kind::Struct { members, .. } => structure(out, &tag, &fields(types, members)),
        Kind::Exception { name, members } => {
            let _ = writeln!(out, "\npub const {}_id: &CStr = c\"{name}\";", name.to_c());
            if !members.is_empty() {
                structure(out, &tag, &fields(types, members));
            }
        }
        Kind::Union { discriminant, members, .. } => {
            let inner = format!("{tag}_members");
            let list = members.iter().map(|m| field(&m.name, &spell(types, m.ty)));
            let list: String = list.collect();
            let _ = write!(
                out,
                "\n#[repr(C)]\n#[derive(Clone, Copy)]\npub union {inner} {{\n{list}}}\n"
            );
            let body = field("_d", &spell(types, *discriminant)) + &field("_u", &inner);
            structure(out, &tag, &body);
        }
        Kind::Sequence { element, bound } => {
            let body = match bound {
                Some(bound) => {
                    field("_maximum", "u32")
                        + &field("_length", "u32")
                        + &field("_buffer", &format!("[{}; {bound}]", spell(types, *element)))
                }
                None => {
                    field("_maximum", "u32")
                        + &field("_length", "u32")
                        + &field("_buffer", &format!("*mut {}", spell(types, *element)))
                        + &field("_release", "Option<unsafe extern \"C\" fn(*mut c_void)>")
                }
            };
            structure(out, &tag, &body);
        }
        Kind::Optional { element } => {
            let body = field("_present", "bool") + &field("_value", &spell(types, *element));
            structure(out, &tag, &body);
        }
        Kind::Native { name } => {
            let name = word(&name.to_c());
            let _ = write!(out, "\n#[repr(C)]\npub struct {name} {{\n    _opaque: [u8; 0],\n}}\n");
        }
        Kind::Typedef { name, target } => {
            let name = word(&name.to_c());
            let _ = writeln!(out, "\npub type {name} = {};", spell(types, *target));
        }
        _ => {}
    }
}

fn structure(out: &mut String, tag: &str, body: &str) {
    let _ = write!(out, "\n#[repr(C)]\n#[derive(Clone, Copy)]\npub struct {tag} {{\n{body}}}\n");
}

fn fields(types: &TypeTable, members: &[Member]) -> String {
    members.iter().map(|m| field(&m.name, &spell(types, m.ty))).collect()
}

fn field(name: &str, ty: &str) -> String {
    format!("    pub {}: {ty},\n", word(name))
}

/// The Rust type of a datum.
fn spell(types: &TypeTable, id: TypeId) -> String {
    if let Some(number) = types.kind(id).rust_number() {
        return number.to_owned();
    }
    match types.kind(id) {
        Kind::Boolean => "bool".to_owned(),
        Kind::String { bound: None } => "*mut c_char".to_owned(),
        Kind::String { bound: Some(bound) } => format!("[c_char; {bound}]"),
        Kind::Array { element, length } => format!("[{}; {length}]", spell(types, *element)),
        Kind::Native { name } => format!("*mut {}", word(&name.to_c())),
        _ => word(&types.c_name(id)),
    }
}

/// A parameter of a codel or remote (genom3.md 5.5).
fn pass(types: &TypeTable, id: TypeId, passing: Passing) -> String {
    let pointer = match passing {
        Passing::Value => "*const",
        Passing::Reference => "*mut",
    };
    match (types.resolved(id), passing) {
        // An array decays into a pointer to its elements.
        (Kind::String { bound: Some(_) }, _) => format!("{pointer} c_char"),
        (Kind::Array { element, .. }, _) => format!("{pointer} {}", spell(types, *element)),
        (Kind::String { bound: None }, Passing::Value) => "*const c_char".to_owned(),
        (Kind::Native { name }, Passing::Value) => format!("*const {}", word(&name.to_c())),
        (
            Kind::Sequence { .. }
            | Kind::Optional { .. }
            | Kind::Struct { .. }
            | Kind::Union { .. }
            | Kind::Exception { .. },
            _,
        )
        | (_, Passing::Reference) => format!("{pointer} {}", spell(types, id)),
        (_, Passing::Value) => spell(types, id),
    }
}

fn constant(types: &TypeTable, ty: TypeId, value: &Value) -> Option<(String, String)> {
    let spelled = spell(types, ty);
    let number = || {
        let signed = value.as_i64().map(i128::from);
        signed.or(value.as_u64().map(i128::from)).unwrap_or_default()
    };
    Some(match types.resolved(ty) {
        Kind::Boolean => ("bool".to_owned(), value.as_bool()?.to_string()),
        Kind::Float | Kind::Double => (spelled, format!("{:?}", value.as_f64()?)),
        Kind::String { .. } => ("&str".to_owned(), format!("{:?}", value.as_str()?)),
        Kind::Char if value.is_string() => {
            (spelled, format!("b{:?} as i8", char::from(value.as_str()?.bytes().next()?)))
        }
        Kind::Enum { name, .. } => {
            let short = value.as_str()?;
            let short = short.rsplit("::").next().unwrap_or(short);
            (spelled, word(&super::types::enumerator(name, short)))
        }
        // A value out of range is truncated, as in C.
        _ => {
            let cut = format!("{}_i128 as {spelled}", number());
            (spelled, cut)
        }
    })
}

fn events(out: &mut String, component: &Component) {
    out.push('\n');
    for (symbol, text) in event_names(component) {
        let _ = writeln!(out, "pub const {symbol}: &CStr = c\"{text}\";");
    }
}

fn handles(out: &mut String, types: &TypeTable, component: &Component) {
    let method = |name: &str, arguments: &str, result: &str| {
        field(name, &format!("unsafe extern \"C\" fn({arguments}) -> {result}"))
    };
    for port in &component.ports {
        let id = if port.multiple { "*const c_char, " } else { "" };
        let arguments = format!("{id}genom_context");
        let data = match types.resolved(port.ty) {
            Kind::String { bound: Some(_) } => "*mut c_char".to_owned(),
            Kind::Array { element, .. } => format!("*mut {}", spell(types, *element)),
            _ => format!("*mut {}", spell(types, port.ty)),
        };
        let mut body = method("data", &arguments, &data);
        let others: &[&str] = match (port.direction, port.multiple) {
            (PortDirection::In, _) => &["read"],
            (PortDirection::Out, false) => &["write"],
            (PortDirection::Out, true) => &["write", "open", "close"],
        };
        body.extend(others.iter().map(|name| method(name, &arguments, "genom_event")));
        structure(out, &format!("{}_{}", component.name, port.name), &body);
    }
    for remote in &component.remotes {
        let pass = |p: &Parameter| pass(types, p.ty, handle::passing(p.direction));
        let mut arguments: Vec<_> = remote.parameters.iter().map(pass).collect();
        arguments.push("genom_context".to_owned());
        let body = method("call", &arguments.join(", "), "genom_event");
        structure(out, &format!("{}_{}", component.name, remote.name), &body);
    }
}

fn prototype(out: &mut String, types: &TypeTable, component: &Component, codel: &Codel) {
    let mut arguments = Vec::new();
    for ((name, source), from) in handle::names(codel).into_iter().zip(&codel.parameters) {
        let handle = match source {
            Source::Port(rank) => component.ports.get(*rank).map(|port| &port.name),
            Source::Remote(rank) => component.remotes.get(*rank).map(|remote| &remote.name),
            _ => None,
        };
        let ty = match handle {
            Some(handle) => format!("*const {}_{handle}", component.name),
            None => pass(types, from.ty, handle::passing(from.direction)),
        };
        arguments.push(format!("    {}: {ty},\n", word(&name)));
    }
    let _ = write!(
        out,
        "\n/// Prototype of codel `{}`.\npub type {}_codel = unsafe extern \"C\" fn(\n{}    self_: genom_context,\n) -> genom_event;\n",
        codel.name,
        codel.name,
        arguments.concat()
    );
}

/// The name, as a raw identifier or with a suffix if it is a keyword of Rust.
fn word(name: &str) -> String {
    const KEYWORDS: &[&str] = &[
        "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do",
        "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in",
        "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref",
        "return", "static", "struct", "trait", "true", "try", "type", "typeof", "unsafe",
        "unsized", "use", "virtual", "where", "while", "yield",
    ];
    match name {
        "self" | "Self" | "super" | "crate" | "_" => format!("{name}_"),
        _ if KEYWORDS.contains(&name) => format!("r#{name}"),
        _ => name.to_owned(),
    }
}
