//! The parts of an instance, laid out and prepared; records all errors.

use std::sync::{Arc, OnceLock};

use genom_description::model::{
    CodelIx, Indexed, Port, PortIx, RemoteIx, Service, ServiceIx, StateIx,
};
use genom_elf::languages;
use genom_runtime::plan::{Event, Meaning, Plan};
use genom_types::{DataType, Kind, Record, ScopedName, TypeTable};

use super::checker::Checker;
use super::code::{Code, Placed};
use super::codel::{Prepared, Workshop};
use super::cxx::CxxTypes;
use super::error::LoadError;
use super::inner::{AllDescribed, Ids, InCpp, Inner, Meant, Memory, Owned};
use super::types::ServiceTypes;
use crate::context::Contexts;
use crate::cxx::{CxxType, DetailError, Exceptions, Object};
use crate::detail::{Details, MWERR, SYSERR, UNKEX};
use crate::events::Events;
use crate::exchanged::Exchanged;
use crate::library::Library;
use crate::ports::{InCxx, Ports};
use crate::remotes::{Remotes, Signature};
use crate::shared::Shared;

/// Events that the host itself may pass to a library, besides declared exceptions.
const GIVEN: &[&str] = &[
    "::genom::fatal",
    UNKEX,
    SYSERR,
    MWERR,
    "::genom::serialization",
    "::genom::port_io",
    "::genom::no_such_inport",
    "::genom::no_such_outport",
    "::genom::no_such_service",
    "::genom::remote_io",
];

/// Languages of scripts, for a message.
fn scripts() -> String {
    let each = |(name, extension)| format!("lang \"{name}\" in a file .{extension}");
    languages::all().map(each).collect::<Vec<_>>().join(", ")
}

/// All parts whose preparation can fail.
pub(super) struct Parts {
    pub(super) ids: Option<DataType>,
    pub(super) services: Indexed<ServiceIx, Option<ServiceTypes>>,
    pub(super) codels: Indexed<CodelIx, Option<(Prepared, Placed)>>,
    pub(super) ports: Indexed<PortIx, Option<DataType>>,
    pub(super) remotes: Indexed<RemoteIx, Option<Signature>>,
    pub(super) details: Details,
    pub(super) nothing: DataType,
    pub(super) cxx: Option<(CxxTypes, Exceptions)>,
}

impl Parts {
    pub(super) fn new(checker: &mut Checker<'_>, plan: &Plan, library: &Library) -> Option<Self> {
        let model = plan.component();
        let called = match languages::of(library.path()) {
            Some(language) if library.is_script() => model.lang == language,
            _ => ["c", "c++"].contains(&model.lang.as_str()),
        };
        if !called {
            checker.errors.push(LoadError::Language {
                component: model.name.clone(),
                place: (checker.locate)(model.span),
                lang: model.lang.clone(),
                scripts: scripts(),
            });
            return None;
        }
        let ids = model.ids.and_then(|ids| checker.lay_out(ids, "the ids", model.span));
        let services = model
            .services
            .map(|_, service| ServiceTypes::new(checker, service, ids.as_ref(), model.dialect));
        let port =
            |port: &Port| checker.lay_out(port.ty, &format!("port `{}`", port.name), port.span);
        let ports: Indexed<PortIx, _> = model.ports.iter().map(port).collect();
        if model.lang == "c++" && library.needs("libc++.so") {
            checker.errors.push(LoadError::OtherLibrary { component: model.name.clone() });
        }
        let cxx = (model.lang == "c++")
            .then(|| CxxTypes::new(checker, model, ids.as_ref(), &services, &ports));
        let (ids_ref, cxx_ref) = (ids.as_ref(), cxx.as_ref());
        let workshop = Workshop { model, library, ids: ids_ref, services: &services, cxx: cxx_ref };
        let codels = model.codels.iter().map(|codel| workshop.prepare(checker, codel)).collect();
        let mut details = Details::default();
        for event in plan.events() {
            let Meaning::Exception(Some(id)) = event.meaning else { continue };
            let thrown = model.throws.contains(&id);
            let has_detail = !checker.specification.types.members(id).is_empty();
            let ty = match (has_detail, thrown) {
                (false, _) => None,
                (true, true) => {
                    checker.lay_out(id, &format!("exception {}", event.name), model.span)
                }
                // An exception of another component, whose type may be incomplete here.
                (true, false) => DataType::new(&checker.specification.types, id).ok(),
            };
            details.add(event.name.clone(), ty);
        }
        let signature = |remote| {
            let in_cxx = model.lang == "c++";
            Signature::new(remote, in_cxx, |ty, what, span| checker.lay_out(ty, what, span))
        };
        let remotes = model.remotes.iter().map(signature).collect();
        let mut table = TypeTable::default();
        let name = ScopedName::new(["nothing"]);
        let nothing = table.add(Kind::Struct { name, members: Vec::new() });
        let nothing = DataType::new(&Arc::new(table), nothing).ok()?;
        let cxx = cxx.and_then(|cxx| {
            let exceptions = Exceptions::new(library, details.types(), GIVEN);
            let refuse = |error: DetailError| {
                let place = (checker.locate)(model.span);
                let what = format!("exception {}", error.exception);
                checker.errors.push(LoadError::Type { what, place, why: error.why.to_string() });
            };
            exceptions.map_err(refuse).ok().map(|exceptions| (cxx, exceptions))
        });
        Some(Self { ids, services, codels, ports, remotes, details, nothing, cxx })
    }

    /// Assembles the instance; `None` without memory for executable code, the only error left.
    pub(super) fn assemble(self, plan: &Plan, mut library: Library) -> Option<Inner> {
        library.forget_contents();
        let model = plan.component();
        let events: Vec<String> = plan.events().iter().map(|event| event.name.clone()).collect();
        let given = GIVEN.iter().copied().chain(self.details.names());
        let table = Events::new(&library, events.iter().map(String::as_str), given);
        let fatal = table.pointer("::genom::fatal").unwrap_or(std::ptr::null());
        let contexts = Contexts::new(plan.contexts(), self.details.room(), fatal);
        let shared = Arc::new(Shared { events: Exchanged::new(table), contexts });
        let details = Arc::new(self.details);
        let types: Indexed<PortIx, DataType> = self.ports.into_iter().collect::<Option<_>>()?;
        let signatures = self.remotes.into_iter().collect::<Option<Indexed<_, _>>>()?;
        let in_cxx = |(cxx, exceptions): (CxxTypes, Exceptions)| {
            let ports: Indexed<PortIx, CxxType> = cxx.ports.into_iter().collect::<Option<_>>()?;
            let services = cxx.services.into_iter().collect::<Option<_>>()?;
            let exceptions = Arc::new(exceptions);
            let in_ports = InCxx { types: ports, exceptions: Arc::clone(&exceptions) };
            Some((cxx.ids, in_ports, InCpp { services, exceptions }))
        };
        let (ids_in_cxx, ports_in_cxx, cxx) = match self.cxx {
            Some(cxx) => {
                let (ids, ports, cxx) = in_cxx(cxx)?;
                (ids, Some(ports), Some(cxx))
            }
            None => (None, None, None),
        };
        let (codels, functions): (Vec<_>, Vec<_>) =
            self.codels.into_iter().map(Option::unzip).unzip();
        let of =
            |service: &Service| service.validates.iter().chain(&service.codels).copied().collect();
        Some(Inner {
            ids: self.ids.map(|ty| match ids_in_cxx {
                Some(ty) => {
                    let object = Object::new(&ty);
                    let at = object.at() as usize;
                    Ids { memory: Memory::Cxx(object), at }
                }
                None => {
                    let mut record = Record::new(&ty);
                    let at = record.as_mut_ptr() as usize;
                    Ids { memory: Memory::C(record), at }
                }
            }),
            ports: Ports::new(&model.ports, &types, ports_in_cxx.as_ref(), &shared)?,
            remotes: {
                let exceptions = cxx.as_ref().map(|cxx| &cxx.exceptions);
                Remotes::new(signatures, &shared, &details, exceptions)?
            },
            codels: codels.into_iter().collect(),
            services: self.services.into_iter().collect::<Option<_>>()?,
            owned: Owned {
                services: model.services.iter().map(of).collect(),
                tasks: model.tasks.iter().map(|task| task.codels.clone()).collect(),
            },
            cxx,
            meant: plan
                .events()
                .iter()
                .map(|event| meant(event, &details, &model.states))
                .collect(),
            described: AllDescribed::new(plan),
            instance: OnceLock::new(),
            damage: OnceLock::new(),
            events,
            shared,
            details,
            nothing: self.nothing,
            pinned: Arc::default(),
            pins: OnceLock::new(),
            code: Exchanged::new(Code::new(functions.into_iter().collect(), library)),
        })
    }
}

fn meant(event: &Event, details: &Details, states: &Indexed<StateIx, String>) -> Meant {
    let rests = match event.meaning {
        Meaning::State { state, pause } => {
            pause || states.get(state).is_some_and(|name| name == "ether")
        }
        Meaning::Exception(_) => true,
    };
    Meant { exception: details.is_exception(&event.name), rests }
}
