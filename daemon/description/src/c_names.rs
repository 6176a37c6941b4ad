//! C names of types, events and other items in the header for codels, and clashes between them.
//!
//! Scopes are joined by `_`, so that `a::b_c` and `a_b::c` are both `a_b_c` (genom3.md 5.1).

use std::collections::{BTreeSet, HashMap, HashSet};

use genom_types::{Kind, TypeId, TypeTable};

use crate::model::{CodelKind, Component, Constant, Span, Specification, StateIx};

/// An item that has a C name.
#[derive(Clone, Debug)]
pub struct CName {
    /// Its full name in IDL.
    pub idl: String,
    /// Its position.
    pub place: Place,
}

/// Position of an item that has a C name.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// That of the declaration of this type.
    Type(TypeId),
    /// This one.
    At(Span),
}

/// Pairs of different items that have one C name, with that name. Types in `without` are ignored,
/// because no header contains them.
#[must_use]
pub fn clashes<'s>(
    types: &TypeTable,
    constants: &[Constant],
    components: impl IntoIterator<Item = &'s Component>,
    without: &HashSet<TypeId>,
) -> Vec<(String, CName, CName)> {
    let mut found = Found::default();
    for (id, kind) in types.iter().filter(|(id, _)| !without.contains(id)) {
        let Some(name) = kind.name().filter(|_| !matches!(kind, Kind::Forward { .. })) else {
            continue;
        };
        found.add(name.to_c(), name.to_string(), Place::Type(id));
        if let Kind::Enum { enumerators, .. } = kind {
            let scope = name.segments().split_last().map_or(&[][..], |(_, outer)| outer);
            for one in enumerators {
                let all = scope.iter().map(String::as_str).chain([one.as_str()]);
                let segments: Vec<&str> = all.collect();
                let idl = format!("::{}", segments.join("::"));
                found.add(segments.join("_"), idl, Place::Type(id));
            }
        }
    }
    for constant in constants {
        let name = &constant.name;
        found.add(name.to_c(), name.to_string(), Place::At(constant.span));
    }
    for component in components {
        let own = &component.name;
        let ports = component.ports.iter().map(|port| (&port.name, port.span));
        let remotes = component.remotes.iter().map(|remote| (&remote.name, remote.span));
        for (name, span) in ports.chain(remotes) {
            found.add(format!("{own}_{name}"), format!("::{own}::{name}"), Place::At(span));
        }
        for (symbol, text) in event_names(component) {
            found.add(symbol, text, Place::At(component.span));
        }
    }
    found.clashes
}

#[derive(Default)]
struct Found {
    known: HashMap<String, (String, Place)>,
    clashes: Vec<(String, CName, CName)>,
}

impl Found {
    fn add(&mut self, c: String, idl: String, place: Place) {
        match self.known.get(&c) {
            None => _ = self.known.insert(c, (idl, place)),
            Some((other, _)) if *other == idl => {}
            Some((other, first)) => {
                let first = CName { idl: other.clone(), place: *first };
                self.clashes.push((c, first, CName { idl, place }));
            }
        }
    }
}

/// Structs that genomd makes of the parameters of services: no codel sees them.
#[must_use]
pub fn records(spec: &Specification) -> HashSet<TypeId> {
    let of_component = |component: &Component| {
        let services = component.services.iter().flat_map(|s| [s.input, s.output, s.local]);
        let remotes = component.remotes.iter().flat_map(|r| [r.input, r.output]);
        services.chain(remotes).collect::<Vec<_>>()
    };
    let mut records: HashSet<TypeId> = spec.components.iter().flat_map(of_component).collect();
    // For services of interfaces only the names are known: `::interface::service::input`. A struct
    // that is used as a member was declared by the user.
    let services: HashSet<(&str, &str)> = spec
        .interfaces
        .iter()
        .flat_map(|i| i.services.iter().map(|service| (i.name.as_str(), service.as_str())))
        .collect();
    let held: HashSet<TypeId> =
        spec.types.iter().flat_map(|(id, _)| contained(&spec.types, id)).collect();
    for (id, kind) in spec.types.iter() {
        if let Kind::Struct { name, .. } = kind
            && let [interface, service, part] = name.segments()
            && matches!(part.as_str(), "input" | "output" | "local")
            && services.contains(&(interface.as_str(), service.as_str()))
            && !held.contains(&id)
        {
            records.insert(id);
        }
    }
    records
}

/// Types that C needs complete before it can define this one.
#[must_use]
pub fn contained(types: &TypeTable, id: TypeId) -> Vec<TypeId> {
    match types.kind(id) {
        Kind::Array { element, .. }
        | Kind::Sequence { element, .. }
        | Kind::Optional { element } => vec![*element],
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
            members.iter().map(|member| member.ty).collect()
        }
        Kind::Union { discriminant, members, .. } => {
            std::iter::once(*discriminant).chain(members.iter().map(|m| m.ty)).collect()
        }
        Kind::Typedef { target, .. } => vec![*target],
        _ => Vec::new(),
    }
}

/// C name and name of each event of a component.
///
/// In the figures of the papers a codel can have the C name of an event (`demo_stop`). The codel
/// keeps it, because the host calls it by that name, and the event becomes `demo_stop_event`.
#[must_use]
pub fn event_names(component: &Component) -> Vec<(String, String)> {
    let name = &component.name;
    let codels: HashSet<&str> = component.codels.iter().map(|codel| codel.name.as_str()).collect();
    let states = component.states.iter().map(|state| (state.clone(), state.clone()));
    let paused = paused(component).into_iter().filter_map(|rank| component.states.get(rank));
    let paused = paused.map(|state| (format!("pause_{state}"), format!("pause::{state}")));
    let named = states.chain(paused).map(|(symbol, text)| {
        let mut symbol = format!("{name}_{symbol}");
        if codels.contains(symbol.as_str()) {
            symbol.push_str("_event");
        }
        (symbol, format!("::{name}::{text}"))
    });
    named.collect()
}

/// States that some codel yields with a pause.
#[must_use]
pub fn paused(component: &Component) -> BTreeSet<StateIx> {
    let yields = component.codels.iter().flat_map(|codel| match &codel.kind {
        CodelKind::Fsm { yields, .. } => yields.as_slice(),
        _ => &[],
    });
    yields.filter(|to| to.pause).map(|to| to.state).collect()
}

/// Whether C or C++ reserves the name: a keyword, or a macro of the headers that codels include.
#[must_use]
pub fn is_taken(name: &str) -> bool {
    const TAKEN: &[&str] = &[
        "NULL",
        "alignas",
        "alignof",
        "and",
        "and_eq",
        "asm",
        "assert",
        "auto",
        "bitand",
        "bitor",
        "bool",
        "break",
        "case",
        "catch",
        "char",
        "class",
        "compl",
        "const",
        "constexpr",
        "continue",
        "decltype",
        "default",
        "delete",
        "do",
        "double",
        "else",
        "enum",
        "errno",
        "explicit",
        "export",
        "extern",
        "false",
        "float",
        "for",
        "friend",
        "goto",
        "if",
        "inline",
        "int",
        "linux",
        "long",
        "mutable",
        "namespace",
        "new",
        "noexcept",
        "not",
        "not_eq",
        "nullptr",
        "operator",
        "or",
        "or_eq",
        "private",
        "protected",
        "public",
        "register",
        "requires",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "stderr",
        "stdin",
        "stdout",
        "struct",
        "switch",
        "template",
        "this",
        "throw",
        "true",
        "try",
        "typedef",
        "typeid",
        "typename",
        "typeof",
        "union",
        "unix",
        "unsigned",
        "using",
        "virtual",
        "void",
        "volatile",
        "while",
        "xor",
        "xor_eq",
    ];
    TAKEN.contains(&name)
}
