//! Checks how a description maps to C: types without a layout are refused, since no daemon can load
//! them; names that are reserved in C, or clash there, are a warning.

use std::collections::HashSet;
use std::sync::Arc;

use genom_types::{DataType, Kind, TypeId, TypeTable};

use super::Checker;
use crate::c_names::{Place, clashes, is_taken, records};
use crate::diagnostic::Diagnostic;
use crate::model::{Component, Specification};

impl Checker {
    /// Reports the first type of each component that has no layout.
    pub(super) fn check_layouts(&mut self, types: &Arc<TypeTable>, component: &Component) {
        let mut seen: HashSet<TypeId> = HashSet::new();
        // Members first, since they have positions; then the whole struct.
        let members = component.ids.map_or(&[][..], |ids| types.members(ids));
        let spans = self.body_index.get(component.name.as_str());
        let spans = spans.map_or(&[][..], |id| &self.bodies[*id].ids_members);
        let members = members.iter().map(|member| member.ty).zip(spans.to_vec());
        let ids = members.chain(component.ids.map(|ids| (ids, component.span)));
        let ports = component.ports.iter().map(|port| (port.ty, port.span));
        let services = component.services.iter();
        let parameters = services.flat_map(|s| s.parameters.iter().chain(&s.locals));
        let parameters = parameters.map(|parameter| (parameter.ty, parameter.span));
        for (ty, span) in ids.chain(ports).chain(parameters) {
            if !seen.insert(types.resolve(ty)) {
                continue;
            }
            if let Err(error) = DataType::new(types, ty) {
                self.push(Diagnostic::error("E0216", span, error.to_string()));
                return;
            }
        }
    }

    /// Warns of names that cannot be used in the header for codels.
    pub(super) fn warn_names(&mut self, specification: &Specification) {
        if self.diagnostics.errors() > 0 {
            return;
        }
        let types = &specification.types;
        let without = records(specification);
        for (id, kind) in types.iter().filter(|(id, _)| !without.contains(id)) {
            let members: Vec<&str> = match kind {
                Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
                    members.iter().map(|member| member.name.as_str()).collect()
                }
                Kind::Union { members, .. } => members.iter().map(|m| m.name.as_str()).collect(),
                _ => Vec::new(),
            };
            let own = kind.name().filter(|name| name.segments().len() == 1);
            let words = members.iter().copied().chain(own.map(|name| name.last()));
            for word in words.filter(|word| is_taken(word)) {
                let owner = kind.name().map(ToString::to_string).unwrap_or_default();
                let message = format!("`{word}` in `{owner}` is a word of C or C++");
                let span = self.facts(id).span.unwrap_or_default();
                self.push(
                    Diagnostic::warning("W0908", span, message)
                        .help("the header of codels does not compile: choose another name"),
                );
            }
        }
        let all = clashes(types, &specification.constants, &specification.components, &without);
        for (c, first, second) in all {
            let place = |place: Place| match place {
                Place::Type(id) => self.facts(id).span.unwrap_or_default(),
                Place::At(span) => span,
            };
            let message = format!("`{}` and `{}` have one name in C, `{c}`", first.idl, second.idl);
            let warning = Diagnostic::warning("W0909", place(second.place), message)
                .note(place(first.place), "the other one")
                .help("no header can be made for codels: rename one of them");
            self.push(warning);
        }
    }
}
