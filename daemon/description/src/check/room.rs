//! Limits the memory of a checked description.
//!
//! A short text may expand to much: an interface that extends another one inherits all its parts,
//! and every service of a component throws all that the component throws. Bytes are counted before
//! anything is made.

use genom_types::{Kind, ScopedName};
use serde_json::Value as Json;

use super::Checker;
use super::state::{BodyId, CodelState, Parameter, Service, Task};
use crate::diagnostic::Diagnostic;
use crate::model::{self, Default as DefaultValue, Source, Span};

/// Bytes for types, values, services and codels.
const ROOM: usize = 128 << 20;

/// Bytes of an empty component or interface with its scopes, states and tables.
pub(super) const BODY: usize = 4096;
/// Bytes of an empty scope.
pub(super) const SCOPE: usize = 384;
/// Bytes of a string, list or table in addition to its content.
const HEAP: usize = 32;

impl Checker {
    /// Counts bytes for what is about to be made for the text at `span`; false when the limit is
    /// exceeded.
    pub(super) fn reserve(&mut self, bytes: usize, span: Span) -> bool {
        if self.taken.full {
            return false;
        }
        self.taken.bytes = self.taken.bytes.saturating_add(bytes);
        if self.taken.bytes > ROOM {
            self.taken.full = true;
            let message = format!("here the description takes more than {} MiB", ROOM >> 20);
            self.push(Diagnostic::error("E0408", span, message).help(
                "interfaces hand on all that they have: let them have less, or extend fewer",
            ));
        }
        !self.taken.full
    }

    /// Bytes of what an interface hands on to a body that it is merged into.
    pub(super) fn handed_on(&self, from: BodyId) -> usize {
        let body = &self.bodies[from];
        let texts = [&body.docs, &body.requires, &body.codels_requires].into_iter().flatten();
        let members = body.ids.map_or(&[][..], |ids| self.types.members(ids));
        let properties = list(texts, |text| HEAP + text.len()) + entries(body.throws.len());
        let data = list(members, |member| 4 * HEAP + member.name.len());
        let ports =
            list(body.ports.values(), |port| 4 * HEAP + list(&port.docs, |text| HEAP + text.len()));
        let remotes = body.remotes.len() * 4 * HEAP;
        properties
            + data
            + ports
            + remotes
            + list(body.tasks.values(), task)
            + list(body.services.values(), service)
    }

    /// Bytes of a complete component, without its types.
    pub(super) fn complete(&self, id: BodyId) -> usize {
        let body = &self.bodies[id];
        let all = body.services.len();
        let common = body.throws.len() * size_of::<genom_types::TypeId>();
        let services = list(body.services.values(), |one| {
            let names = [one.before.as_ref(), one.after.as_ref()].into_iter().flatten();
            let names = names.map(|(names, _)| names).chain([&one.interrupts]);
            let ranks = list(names, |names| {
                let every = names.iter().any(|name| &*name.text == "all");
                size_of::<usize>() * if every { all } else { names.len() }
            });
            let codels = one.validates.iter().chain(&one.codels);
            size_of::<model::Service>() + common + ranks + list(codels, model_codel)
        });
        let tasks = list(body.tasks.values(), |one| {
            size_of::<model::Task>() + common + list(&one.codels, model_codel)
        });
        let remotes = list(body.remotes.values(), |remote| {
            let interface = &self.bodies[remote.interface];
            let service = interface.services.get_index(remote.service);
            size_of::<model::Remote>()
                + common
                + service.map_or(0, |(_, service)| list(&service.parameters, parameter))
        });
        size_of::<model::Component>() + services + tasks + remotes
    }
}

/// Bytes of a type and its names.
pub(super) fn of_type(kind: &Kind) -> usize {
    let members = match kind {
        Kind::Struct { members, .. } | Kind::Exception { members, .. } => {
            list(members, |member| 2 * HEAP + member.name.len())
        }
        Kind::Union { members, .. } => list(members, |member| 3 * HEAP + member.name.len()),
        Kind::Enum { enumerators, .. } => list(enumerators, |name| HEAP + name.len()),
        _ => 0,
    };
    size_of::<Kind>() + HEAP + kind.name().map_or(0, of_name) + members
}

fn of_name(name: &ScopedName) -> usize {
    list(name.segments(), |segment| HEAP + segment.len())
}

/// Bytes of the value of a constant or parameter.
pub(super) fn of_json(value: &Json) -> usize {
    size_of::<Json>()
        + match value {
            Json::String(text) => text.len(),
            Json::Array(items) => list(items, of_json),
            Json::Object(members) => {
                list(members, |(name, value)| HEAP + name.len() + of_json(value))
            }
            _ => 0,
        }
}

fn of_default(value: &DefaultValue) -> usize {
    let docs = list(&value.member_docs, |(place, doc)| 2 * HEAP + place.len() + doc.len());
    value.value.as_ref().map_or(0, of_json) + value.doc.as_ref().map_or(0, String::len) + docs
}

pub(super) fn task(task: &Task) -> usize {
    size_of::<Task>()
        + list(&task.docs, |text| HEAP + text.len())
        + entries(task.throws.len())
        + list(&task.codels, codel)
}

pub(super) fn service(service: &Service) -> usize {
    let names = [service.before.as_ref(), service.after.as_ref()].into_iter().flatten();
    let names = service.interrupts.len() + list(names, |(names, _)| names.len());
    size_of::<Service>()
        + HEAP
        + list(&service.docs, |text| HEAP + text.len())
        + list(service.parameters.iter().chain(&service.locals), parameter)
        + list(service.validates.iter().chain(&service.codels), codel)
        + entries(service.throws.len())
        + names * HEAP
}

fn parameter(parameter: &Parameter) -> usize {
    let target = parameter.target.as_ref();
    size_of::<Parameter>()
        + target.map_or(0, |target| {
            let variable = target.variable.as_ref();
            HEAP * (target.path.len() + variable.map_or(0, |v| 4 * v.steps.len()))
        })
        + parameter.default.as_ref().map_or(0, of_default)
}

fn codel(codel: &CodelState) -> usize {
    size_of::<CodelState>()
        + HEAP * (codel.triggers.len() + codel.yields.len())
        + list(&codel.parameters, |parameter| {
            size_of_val(parameter) + HEAP * path_length(&parameter.source)
        })
}

fn model_codel(codel: &CodelState) -> usize {
    size_of::<model::Codel>()
        + codel.syntax.name.text.len()
        + list(&codel.parameters, |parameter| {
            size_of::<model::CodelParameter>() + parameter.name.len()
        })
}

fn path_length(source: &Source) -> usize {
    match source {
        Source::Ids { path } | Source::Parameter { path, .. } | Source::Local { path, .. } => {
            path.len()
        }
        Source::Port(_) | Source::Remote(_) => 0,
    }
}

fn list<T>(items: impl IntoIterator<Item = T>, size: impl Fn(T) -> usize) -> usize {
    items.into_iter().map(size).sum()
}

/// Bytes of a table of `count` types.
fn entries(count: usize) -> usize {
    count * HEAP
}
