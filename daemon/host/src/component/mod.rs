//! A component's code and memory: what the runtime calls a body. One of the few unsafe modules.
#![allow(unsafe_code)]

mod codel;
mod cxx;
mod error;
mod frame;
mod types;
mod way;
mod zones;

pub use error::{LoadError, LoadErrors};
pub use zones::{MemoryCheck, check_memory};

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use genom_description::model::{Owner, Port, Service, Span};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, Frame, Opener, RemoteCall};
use genom_runtime::plan::{Event, Meaning, Plan};
use genom_types::{DataType, Kind, Record, ScopedName, TypeTable, Zones};
use serde_json::Value;

use crate::context::Contexts;
use crate::contract;
use crate::cxx::{CxxType, Exceptions, Object};
use crate::detail::{Details, MWERR, SYSERR, UNKEX};
use crate::events::Events;
use crate::library::Library;
use crate::ports::{InCxx, Ports};
use crate::remotes::Remotes;
use crate::shared::Shared;
use codel::{Prepared, Workshop};
use cxx::{CxxService, CxxTypes};
use types::{Checker, ServiceTypes};
use zones::{Described, Watched};

/// Events the host itself may hand to a library, besides declared exceptions.
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

/// One instance of a component: a library of its own, its IDS, ports and remotes.
///
/// The library is closed when the component and the last of its frames are dropped; threads that
/// run codels must have ended by then.
pub struct Component {
    inner: Arc<Inner>,
}

/// What frames hold on to. Fields are dropped in this order: memory before the code that made
/// it, the library last.
struct Inner {
    ids: Option<Ids>,
    ports: Ports,
    remotes: Remotes,
    /// By codel of the model; `None` for those the runtime supplies.
    codels: Vec<Option<Prepared>>,
    services: Vec<ServiceTypes>,
    /// Codels of each service and of each task.
    owned: Owned,
    /// For codels in C++.
    cxx: Option<InCpp>,
    shared: Arc<Shared>,
    details: Arc<Details>,
    /// By event of the plan.
    meant: Vec<Meant>,
    described: AllDescribed,
    /// Where codels wrote past what they were given, once they did.
    damage: OnceLock<String>,
    /// Names of the plan's events, by rank.
    events: Vec<String>,
    /// Type of records that hold nothing.
    nothing: DataType,
    library: Library,
}

impl Drop for Inner {
    /// Codels assign IDS and ports to one another, pointers included: each is freed once. They
    /// leave threads behind, which know the IDS: these stay with them.
    fn drop(&mut self) {
        if let Some(written) = self.all_zones().take_written() {
            let path = self.library.path().display();
            tracing::error!("{path}: codels wrote {written}; found when it was unloaded");
        }
        let mut seen = HashSet::new();
        self.ports.give_up_shared(&mut seen);
        if let Some(Ids { memory: Memory::C(record), .. }) = &mut self.ids {
            record.give_up_shared(&mut seen);
        }
        if self.library.is_outlived() {
            std::mem::forget(self.ids.take());
        }
    }
}

impl Inner {
    /// Watches what these codels may write to besides their own service's memory.
    fn watch(&self, codels: &[usize], watched: &mut Watched) {
        let prepared = codels.iter().filter_map(|codel| self.codels.get(*codel)?.as_ref());
        let arguments = prepared.flat_map(|codel| &codel.arguments);
        let (mut ids, mut ports) = (false, Vec::new());
        for argument in arguments {
            match argument.from {
                codel::From::Ids(_) => ids = true,
                codel::From::Port(port) if !ports.contains(&port) => ports.push(port),
                _ => {}
            }
        }
        if let (true, Some(own), Some(described)) = (ids, &self.ids, &self.described.ids) {
            // SAFETY: frames hold the component, and look only while they live.
            unsafe { watched.add(own.zones(), described) };
        }
        for port in ports {
            if let Some((zones, described)) =
                self.ports.zones(port).zip(self.described.ports.get(port))
            {
                // SAFETY: as above.
                unsafe { watched.add(zones, described) };
            }
        }
    }

    /// What lies around its IDS and its simple ports.
    fn all_zones(&self) -> Watched {
        let mut watched = Watched::default();
        let ports = self.described.ports.iter().enumerate();
        for (rank, described) in ports {
            if let Some(zones) = self.ports.zones(rank) {
                // SAFETY: the ports are asked only as long as they live.
                unsafe { watched.add(zones, described) };
            }
        }
        if let (Some(ids), Some(described)) = (&self.ids, &self.described.ids) {
            // SAFETY: as above.
            unsafe { watched.add(ids.zones(), described) };
        }
        watched
    }
}

/// What an event of the plan means to who calls codels.
#[derive(Clone, Copy)]
struct Meant {
    /// It is an exception, which may have a detail.
    exception: bool,
    /// The codel pauses or has ended: it is time to look at its memory.
    rests: bool,
}

/// Memory of a component in words.
struct AllDescribed {
    ids: Option<Described>,
    /// By service: inputs, outputs, local variables.
    services: Vec<[Described; 3]>,
    ports: Vec<Described>,
}

impl AllDescribed {
    fn new(plan: &Plan) -> Self {
        let (model, types) = (plan.component(), &plan.specification().types);
        let service = |service: &Service| {
            let of = |part: &str, ty| {
                Described::new(format!("the {part} of `{}`", service.name), types, ty)
            };
            [
                of("inputs", service.input),
                of("outputs", service.output),
                of("local variables", service.local),
            ]
        };
        let port = |port: &Port| Described::whole(format!("the data of port `{}`", port.name));
        Self {
            ids: model.ids.map(|ids| Described::new("the ids".to_owned(), types, ids)),
            services: model.services.iter().map(service).collect(),
            ports: model.ports.iter().map(port).collect(),
        }
    }
}

/// The IDS, at an address that never changes.
struct Ids {
    memory: Memory,
    at: usize,
}

enum Memory {
    C(Record),
    Cxx(Object),
}

impl Ids {
    fn zones(&self) -> Zones {
        match &self.memory {
            Memory::C(record) => record.zones(),
            Memory::Cxx(object) => object.zones(),
        }
    }
}

/// What a component in C++ has besides.
struct InCpp {
    services: Vec<CxxService>,
    exceptions: Arc<Exceptions>,
}

/// Codels by owner.
struct Owned {
    services: Vec<Vec<usize>>,
    tasks: Vec<Vec<usize>>,
}

impl Component {
    /// Checks the library against the component of `plan`, and makes the memory of one instance.
    ///
    /// `locate` shows a place of the `.gen` in messages, as file and line.
    ///
    /// # Errors
    /// Everything that is wrong: codels missing in the library, types or arguments without a
    /// place in memory, differences between the library's own types and the description's.
    pub fn load(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Self, LoadErrors> {
        Self::make(library, plan, locate, true)
    }

    /// As [`load`](Self::load), for a library whose contents were loaded with this plan before:
    /// they are not compared again.
    ///
    /// # Errors
    /// As `load`, differences apart.
    pub fn load_again(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
    ) -> Result<Self, LoadErrors> {
        Self::make(library, plan, locate, false)
    }

    fn make(
        library: Library,
        plan: &Plan,
        locate: &dyn Fn(Span) -> String,
        compare: bool,
    ) -> Result<Self, LoadErrors> {
        let mut checker =
            Checker { specification: plan.specification(), locate, errors: Vec::new() };
        let parts = Parts::new(&mut checker, plan, &library);
        let mut errors = checker.errors;
        if compare && parts.is_some() {
            errors.extend(differences(&library, plan, locate));
        }
        let path = library.path().to_owned();
        let refuse = |errors| LoadErrors { library: path, errors };
        match parts {
            Some(parts) if errors.is_empty() => match parts.assemble(plan, library) {
                Some(inner) => Ok(Self { inner: Arc::new(inner) }),
                None => Err(refuse(vec![LoadError::NoClosures])),
            },
            _ => Err(refuse(errors)),
        }
    }

    /// The library file, as it was asked for.
    #[must_use]
    pub fn library(&self) -> PathBuf {
        self.inner.library.path().to_owned()
    }
}

/// What the library and the description see differently.
fn differences(library: &Library, plan: &Plan, locate: &dyn Fn(Span) -> String) -> Vec<LoadError> {
    let report = contract::check(library, plan, locate);
    if let Some(why) = &report.unchecked {
        let path = library.path().display();
        tracing::info!("{path}: unchecked: {why}: nothing to compare with the .gen");
    }
    report.differences.into_iter().map(LoadError::Contract).collect()
}

/// What can be wrong, laid out and prepared.
struct Parts {
    ids: Option<DataType>,
    services: Vec<Option<ServiceTypes>>,
    codels: Vec<Option<Prepared>>,
    ports: Vec<Option<DataType>>,
    remotes: Vec<Option<crate::remotes::Signature>>,
    details: Details,
    nothing: DataType,
    cxx: Option<(CxxTypes, Exceptions)>,
}

impl Parts {
    fn new(checker: &mut Checker<'_>, plan: &Plan, library: &Library) -> Option<Self> {
        let model = plan.component();
        if !["c", "c++"].contains(&model.lang.as_str()) {
            checker.errors.push(LoadError::Language {
                component: model.name.clone(),
                place: (checker.locate)(model.span),
                lang: model.lang.clone(),
            });
            return None;
        }
        let ids = model.ids.and_then(|ids| checker.lay_out(ids, "the ids", model.span));
        let services: Vec<_> = model
            .services
            .iter()
            .map(|service| ServiceTypes::new(checker, service, ids.as_ref(), model.dialect))
            .collect();
        let port =
            |port: &Port| checker.lay_out(port.ty, &format!("port `{}`", port.name), port.span);
        let ports: Vec<_> = model.ports.iter().map(port).collect();
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
                // Another component's: known if it can be.
                (true, false) => DataType::new(&checker.specification.types, id).ok(),
            };
            details.add(event.name.clone(), ty);
        }
        let signature = |remote| {
            let in_cxx = model.lang == "c++";
            crate::remotes::Signature::new(remote, in_cxx, |ty, what, span| {
                checker.lay_out(ty, what, span)
            })
        };
        let remotes = model.remotes.iter().map(signature).collect();
        let mut table = TypeTable::default();
        let name = ScopedName::new(["nothing"]);
        let nothing = table.add(Kind::Struct { name, members: Vec::new() });
        let nothing = DataType::new(&Arc::new(table), nothing).ok()?;
        let cxx = cxx.and_then(|cxx| {
            let exceptions = Exceptions::new(library, details.types(), GIVEN);
            let refuse = |(name, why)| {
                let place = (checker.locate)(model.span);
                let what = format!("exception {name}");
                checker.errors.push(LoadError::Type { what, place, why });
            };
            exceptions.map_err(refuse).ok().map(|exceptions| (cxx, exceptions))
        });
        Some(Self { ids, services, codels, ports, remotes, details, nothing, cxx })
    }

    /// The instance; `None` without memory for executable code. Nothing else is wrong any more.
    fn assemble(self, plan: &Plan, mut library: Library) -> Option<Inner> {
        library.forget_contents();
        let model = plan.component();
        let events: Vec<String> = plan.events().iter().map(|event| event.name.clone()).collect();
        let given = GIVEN.iter().copied().chain(self.details.names());
        let table = Events::new(&library, events.iter().map(String::as_str), given);
        let fatal = table.pointer("::genom::fatal").unwrap_or(std::ptr::null());
        let contexts = Contexts::new(plan.contexts(), self.details.room(), fatal);
        let shared = Arc::new(Shared { events: table, contexts });
        let details = Arc::new(self.details);
        let types: Vec<DataType> = self.ports.into_iter().collect::<Option<_>>()?;
        let signatures = self.remotes.into_iter().collect::<Option<Vec<_>>>()?;
        let in_cxx = |(cxx, exceptions): (CxxTypes, Exceptions)| {
            let ports: Vec<CxxType> = cxx.ports.into_iter().collect::<Option<_>>()?;
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
            codels: self.codels,
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
            damage: OnceLock::new(),
            events,
            shared,
            details,
            nothing: self.nothing,
            library,
        })
    }
}

fn meant(event: &Event, details: &Details, states: &[String]) -> Meant {
    let rests = match event.meaning {
        Meaning::State { state, pause } => {
            pause || states.get(state).is_some_and(|name| name == "ether")
        }
        Meaning::Exception(_) => true,
    };
    Meant { exception: details.is_exception(&event.name), rests }
}

impl Body for Component {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        Box::new(frame::BoundFrame::new(&self.inner, owner))
    }

    fn bind_out(&self, port: usize, element: Option<&str>, publisher: Option<Box<dyn Publisher>>) {
        self.inner.ports.bind_out(port, element, publisher);
    }

    fn bind_in(
        &self,
        port: usize,
        element: Option<&str>,
        subscription: Option<Box<dyn Subscription>>,
    ) {
        self.inner.ports.bind_in(port, element, subscription);
    }

    fn bind_remote(&self, remote: usize, call: Option<Box<dyn RemoteCall>>) {
        self.inner.remotes.bind(remote, call);
    }

    fn set_opener(&self, opener: Box<dyn Opener>) {
        self.inner.ports.set_opener(opener);
    }

    fn port_value(&self, port: usize, element: Option<&str>) -> Option<Value> {
        self.inner.ports.look(port, element, Record::to_json)
    }

    fn port_message(&self, port: usize, element: Option<&str>) -> Option<Vec<u8>> {
        let message = |value: &Record| {
            let mut out = Vec::with_capacity(value.message_size());
            value.encode_message(&mut out).ok().map(|()| out)
        };
        self.inner.ports.look(port, element, message).flatten()
    }

    fn damage(&self) -> Option<String> {
        self.inner.damage.get().cloned()
    }

    fn write_port(&self, port: usize, value: &Record) {
        self.inner.ports.write(port, value);
    }
}
