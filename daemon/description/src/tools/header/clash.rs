//! Names that become one name in C: scopes are joined by `_`, so that `a::b_c` and `a_b::c` are
//! both `a_b_c` (genom3.md 5.1).

use std::collections::{HashMap, HashSet};

use genom_types::{Kind, TypeId, TypeTable};

use super::handle::event_names;
use crate::model::{Component, Constant, Span};

/// What a C name stands for.
pub(crate) struct CName {
    /// Its full name in IDL.
    pub(crate) idl: String,
    pub(crate) place: Place,
}

/// Where it is declared.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    Type(TypeId),
    At(Span),
}

/// Pairs of different things with one name in C, and that name. `without` are types that no
/// header holds.
pub(crate) fn clashes<'s>(
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
