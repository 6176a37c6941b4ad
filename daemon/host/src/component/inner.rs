//! Code and memory of one instance. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

use genom_description::model::{Indexed, Port, PortIx, Service, ServiceIx, TaskIx};
use genom_runtime::plan::Plan;
use genom_types::{DataType, Record, Zones};

use super::codel::{From, Prepared};
use super::cxx::CxxService;
use super::types::ServiceTypes;
use super::zones::{Described, Watched};
use crate::cxx::{Exceptions, Object};
use crate::detail::Details;
use crate::library::Library;
use crate::ports::Ports;
use crate::remotes::Remotes;
use crate::shared::Shared;

/// What frames hold on to. Fields are dropped in this order: memory before the code that made
/// it, the library last.
pub(super) struct Inner {
    pub(super) ids: Option<Ids>,
    pub(super) ports: Ports,
    pub(super) remotes: Remotes,
    /// By codel of the model; `None` for those the runtime supplies.
    pub(super) codels: Vec<Option<Prepared>>,
    pub(super) services: Indexed<ServiceIx, ServiceTypes>,
    /// Codels of each service and of each task.
    pub(super) owned: Owned,
    /// For codels in C++.
    pub(super) cxx: Option<InCpp>,
    pub(super) shared: Arc<Shared>,
    pub(super) details: Arc<Details>,
    /// By event of the plan.
    pub(super) meant: Vec<Meant>,
    pub(super) described: AllDescribed,
    /// Where codels wrote past what they were given, once they did.
    pub(super) damage: OnceLock<String>,
    /// Names of the plan's events, by rank.
    pub(super) events: Vec<String>,
    /// Type of records that hold nothing.
    pub(super) nothing: DataType,
    pub(super) library: Library,
}

impl Drop for Inner {
    /// Codels may copy pointers between IDS and ports, so memory that two of them hold is freed once.
    /// When the library stays mapped for threads that codels left behind, the IDS stay as well.
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
    pub(super) fn watch(&self, codels: &[usize], watched: &mut Watched) {
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
    pub(super) fn all_zones(&self) -> Watched {
        let mut watched = Watched::default();
        for (port, described) in self.described.ports.pairs() {
            if let Some(zones) = self.ports.zones(port) {
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
pub(super) struct Meant {
    /// It is an exception, which may have a detail.
    pub(super) exception: bool,
    /// The codel pauses or has ended: it is time to look at its memory.
    pub(super) rests: bool,
}

/// Memory of a component in words.
pub(super) struct AllDescribed {
    pub(super) ids: Option<Described>,
    /// By service: inputs, outputs, local variables.
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
    pub(super) fn zones(&self) -> Zones {
        match &self.memory {
            Memory::C(record) => record.zones(),
            Memory::Cxx(object) => object.zones(),
        }
    }
}

/// What a component in C++ has besides.
pub(super) struct InCpp {
    pub(super) services: Indexed<ServiceIx, CxxService>,
    pub(super) exceptions: Arc<Exceptions>,
}

/// Codels by owner.
pub(super) struct Owned {
    pub(super) services: Indexed<ServiceIx, Vec<usize>>,
    pub(super) tasks: Indexed<TaskIx, Vec<usize>>,
}
