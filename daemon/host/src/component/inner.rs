//! Code and memory of one instance. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use genom_description::model::{CodelIx, Indexed, Port, PortIx, Service, ServiceIx, TaskIx};
use genom_runtime::Rest;
use genom_runtime::plan::Plan;
use genom_types::{DataType, Record, Zones};

use super::code::Code;
use super::codel::{From, Prepared};
use super::cxx::CxxService;
use super::types::ServiceTypes;
use super::zones::{Described, Watched};
use crate::cxx::{Exceptions, Object};
use crate::detail::Details;
use crate::exchanged::Exchanged;
use crate::ports::Ports;
use crate::remotes::Remotes;
use crate::shared::Shared;

/// State that frames share. Fields are dropped in this order: memory before the code that made it,
/// the library last.
pub(super) struct Inner {
    pub(super) ids: Option<Ids>,
    pub(super) ports: Ports,
    pub(super) remotes: Remotes,
    /// Codels of the model; `None` for those that the runtime supplies.
    pub(super) codels: Indexed<CodelIx, Option<Prepared>>,
    pub(super) services: Indexed<ServiceIx, ServiceTypes>,
    /// Indices of the codels of each service and of each task.
    pub(super) owned: Owned,
    /// For codels in C++.
    pub(super) cxx: Option<InCpp>,
    pub(super) shared: Arc<Shared>,
    pub(super) details: Arc<Details>,
    /// Properties of each event of the plan.
    pub(super) meant: Vec<Meant>,
    pub(super) described: AllDescribed,
    /// Where codels wrote past their memory, once that was detected.
    pub(super) damage: OnceLock<String>,
    /// Instance name, once it is known.
    pub(super) instance: OnceLock<String>,
    /// Names of the plan's events, by index.
    pub(super) events: Vec<String>,
    /// Type of the records of permanent activities: an empty struct.
    pub(super) nothing: DataType,
    /// Whether a library that it ran before stays mapped, whose threads may use its memory.
    pub(super) pinned: Arc<AtomicBool>,
    /// The component that runs on with the memory that the code here used before.
    pub(super) pins: OnceLock<Arc<AtomicBool>>,
    pub(super) code: Exchanged<Code>,
}

impl Drop for Inner {
    /// Codels may copy pointers between IDS and ports, so memory that several of them point to is
    /// freed once. When the library stays mapped because of threads that codels left behind, the
    /// IDS are kept as well.
    fn drop(&mut self) {
        if let Some(written) = self.all_zones().take_written() {
            let path = self.code.get().library.path().display();
            tracing::error!("{path}: codels wrote {written}; found when it was unloaded");
        }
        let mut seen = HashSet::new();
        self.ports.give_up_shared(&mut seen);
        if let Some(Ids { memory: Memory::C(record), .. }) = &mut self.ids {
            record.give_up_shared(&mut seen);
        }
        let outlived = self.code.get_mut().library.is_outlived();
        if outlived {
            std::mem::forget(Arc::clone(&self.shared));
            if let Some(pinned) = self.pins.get() {
                pinned.store(true, Ordering::Release);
            }
        }
        if outlived || self.pinned.load(Ordering::Acquire) {
            std::mem::forget(self.ids.take());
        }
    }
}

impl Inner {
    /// Whether the code of another component works with the memory of this one.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let names = |one: &Self| {
            let codels = one.codels.iter().map(|codel| Some(codel.as_ref()?.name.clone()));
            codels.collect::<Vec<_>>()
        };
        let ids = match (&self.ids, &other.ids) {
            (Some(own), Some(other)) => own.is_like(other),
            (own, other) => own.is_none() && other.is_none(),
        };
        ids && self.events == other.events && names(self) == names(other)
    }

    /// Exchanges the code of this component, which rests, with that of another one like it, which
    /// does not run.
    pub(super) fn exchange(&self, other: &Self, _: Rest<'_>) {
        // SAFETY: no codel of the two runs, and only codels use what is exchanged. Threads that a
        // library started may use the events, too: while they run, its holder keeps them.
        unsafe {
            self.code.swap(&other.code);
            self.shared.exchange(&other.shared);
        }
        if let (Some(own), Some(other)) = (&self.cxx, &other.cxx) {
            own.exceptions.exchange_types(&other.exceptions);
        }
        let _ = other.pins.set(Arc::clone(&self.pinned));
    }

    /// Adds the guard zones of what these codels may write to besides the memory of their own run.
    pub(super) fn watch(&self, codels: &[CodelIx], watched: &mut Watched) {
        let prepared = codels.iter().filter_map(|codel| self.codels.get(*codel)?.as_ref());
        let arguments = prepared.flat_map(|codel| &codel.arguments);
        let (mut ids, mut ports) = (false, Vec::new());
        for argument in arguments {
            match argument.from {
                From::Ids(_) => ids = true,
                From::Port(port) if !ports.contains(&port) => ports.push(port),
                _ => {}
            }
        }
        if let (true, Some(own), Some(described)) = (ids, &self.ids, &self.described.ids) {
            // SAFETY: frames hold the component, and check only while they live.
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

    /// The guard zones of the IDS and of the simple ports.
    pub(super) fn all_zones(&self) -> Watched {
        let mut watched = Watched::default();
        for (port, described) in self.described.ports.pairs() {
            if let Some(zones) = self.ports.zones(port) {
                // SAFETY: the zones are checked only while the ports live.
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

/// Properties of an event that matter when a codel returns it.
#[derive(Clone, Copy)]
pub(super) struct Meant {
    /// Whether it is an exception, which may have a detail.
    pub(super) exception: bool,
    /// Whether the codel pauses or ends with it, so that its memory is checked.
    pub(super) rests: bool,
}

/// Descriptions of a component's memory for messages.
pub(super) struct AllDescribed {
    pub(super) ids: Option<Described>,
    /// For each service: inputs, outputs, local variables.
    pub(super) services: Indexed<ServiceIx, [Described; 3]>,
    pub(super) ports: Indexed<PortIx, Described>,
}

impl AllDescribed {
    pub(super) fn new(plan: &Plan) -> Self {
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
pub(super) struct Ids {
    pub(super) memory: Memory,
    pub(super) at: usize,
}

pub(super) enum Memory {
    C(Record),
    Cxx(Object),
}

impl Ids {
    /// Whether the other ones have the same type and layout.
    fn is_like(&self, other: &Self) -> bool {
        match (&self.memory, &other.memory) {
            (Memory::C(own), Memory::C(other)) => own.ty().same_as(other.ty()),
            (Memory::Cxx(own), Memory::Cxx(other)) => own.ty().c().same_as(other.ty().c()),
            _ => false,
        }
    }

    pub(super) fn zones(&self) -> Zones {
        match &self.memory {
            Memory::C(record) => record.zones(),
            Memory::Cxx(object) => object.zones(),
        }
    }
}

/// Additional state of a component in C++.
pub(super) struct InCpp {
    pub(super) services: Indexed<ServiceIx, CxxService>,
    pub(super) exceptions: Arc<Exceptions>,
}

/// Indices of codels by owner.
pub(super) struct Owned {
    pub(super) services: Indexed<ServiceIx, Vec<CodelIx>>,
    pub(super) tasks: Indexed<TaskIx, Vec<CodelIx>>,
}
