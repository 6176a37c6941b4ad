//! Ports as codels see them: a handle of C functions, a buffer, and what it is bound to.
//!
//! The middleware is not known here.

mod buffers;
mod cxx;
mod element;
mod methods;
mod multiple;
mod snapshot;

use std::collections::HashSet;
use std::ffi::c_void;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_description::model::{Indexed, Port, PortDirection, PortIx};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::Opener;
use genom_types::{DataType, Record, Zones};

use crate::cxx::{CxxType, Exceptions};
use crate::ffi::NativeFunction;
use crate::shared::Shared;
use buffers::Buffers;
use element::{Element, Link};
use multiple::Elements;

/// The ports of one component.
pub(crate) struct Ports {
    ports: Indexed<PortIx, Handle>,
    opener: Arc<OnceLock<Box<dyn Opener>>>,
}

/// A port: `comp_p` of genom3.md 5.7 or 6, and the buffers of its functions.
struct Handle {
    name: String,
    buffers: Buffers,
    interface: Interface,
    /// Values that codels have written.
    written: Arc<AtomicU64>,
}

/// The handle whose address codels get.
enum Interface {
    /// A struct of functions: `data`, then `read` or `write`, `open`, `close`.
    C { table: Box<[usize]>, _functions: Vec<NativeFunction> },
    /// An object with virtual functions.
    Cxx(crate::cxx::Handle),
}

/// Additional data for the ports of a component in C++.
pub(crate) struct InCxx {
    /// Type of each port.
    pub(crate) types: Indexed<PortIx, CxxType>,
    pub(crate) exceptions: Arc<Exceptions>,
}

impl Ports {
    /// Makes the handles of `ports`; `None` when there is no memory for executable code.
    pub(crate) fn new(
        ports: &Indexed<PortIx, Port>,
        types: &Indexed<PortIx, DataType>,
        cxx: Option<&InCxx>,
        shared: &Arc<Shared>,
    ) -> Option<Self> {
        let opener = Arc::new(OnceLock::new());
        let handle = |(ix, port): (PortIx, &Port)| {
            let ty = &types[ix];
            let in_cxx = cxx.and_then(|cxx| cxx.types.get(ix));
            let direction = port.direction;
            let written = Arc::new(AtomicU64::new(0));
            let buffers = if port.multiple {
                let opener = Arc::clone(&opener);
                Buffers::Multiple(Arc::new(Elements::new(
                    ix,
                    direction,
                    ty,
                    in_cxx,
                    opener,
                    Arc::clone(&written),
                )))
            } else {
                let link = Link::unbound(direction);
                Buffers::Simple(Arc::new(Element::new(ty, in_cxx, link, &written)))
            };
            let interface = match cxx {
                Some(cxx) => {
                    let interface =
                        Box::new(cxx::PortInCxx { direction, buffers: buffers.clone() });
                    let out = direction == PortDirection::Out;
                    let kind = (out, port.multiple);
                    Interface::Cxx(crate::cxx::Handle::new(interface, kind, &cxx.exceptions))
                }
                None => {
                    let functions = methods::functions(direction, &buffers, shared)?;
                    let table = functions.iter().map(NativeFunction::address).collect();
                    Interface::C { table, _functions: functions }
                }
            };
            Some(Handle { name: port.name.clone(), buffers, interface, written })
        };
        let ports = ports.pairs().map(handle).collect::<Option<_>>()?;
        Some(Self { ports, opener })
    }

    /// The address that codels get for the port.
    pub(crate) fn handle(&self, port: PortIx) -> *const c_void {
        match &self.ports[port].interface {
            Interface::C { table, .. } => table.as_ptr().cast(),
            Interface::Cxx(handle) => handle.address(),
        }
    }

    /// How many values codels have written on a port.
    pub(crate) fn written(&self, port: PortIx) -> u64 {
        self.ports.get(port).map_or(0, |handle| handle.written.load(Ordering::Relaxed))
    }

    /// Binds an out port, or one of its elements.
    pub(crate) fn bind_out(
        &self,
        port: PortIx,
        element: Option<&str>,
        publisher: Option<Box<dyn Publisher>>,
    ) {
        self.bind(port, element, Link::Out(publisher));
    }

    /// Binds an in port, or one of its elements.
    pub(crate) fn bind_in(
        &self,
        port: PortIx,
        element: Option<&str>,
        subscription: Option<Box<dyn Subscription>>,
    ) {
        self.bind(port, element, Link::In(subscription));
    }

    fn bind(&self, port: PortIx, element: Option<&str>, link: Link) {
        let Some(handle) = self.ports.get(port) else { return };
        match (&handle.buffers, element) {
            (Buffers::Simple(buffer), None) => drop(buffer.bind(link)),
            (Buffers::Multiple(elements), Some(name)) => elements.bind(name, link),
            (Buffers::Simple(_), Some(name)) => {
                tracing::error!("port {} has no elements, thus no {name}", handle.name);
            }
            (Buffers::Multiple(_), None) => {
                tracing::error!(
                    "port {} is multiple: an element is bound, not the port",
                    handle.name
                );
            }
        }
    }

    /// Guard zones around the buffer of a simple port.
    pub(crate) fn zones(&self, port: PortIx) -> Option<Zones> {
        match &self.ports.get(port)?.buffers {
            Buffers::Simple(buffer) => Some(buffer.zones()),
            Buffers::Multiple(_) => None,
        }
    }

    /// Sets how `open` of multiple ports gets its publishers. The first one that is set stays.
    pub(crate) fn set_opener(&self, opener: Box<dyn Opener>) {
        if self.opener.set(opener).is_err() {
            tracing::error!("the opener of a component's ports was set twice; the first stays");
        }
    }

    /// Drops ownership of buffers that are in `seen`, since other records own them too.
    pub(crate) fn give_up_shared(&self, seen: &mut HashSet<usize>) {
        for port in &self.ports {
            match &port.buffers {
                Buffers::Simple(buffer) => buffer.give_up_shared(seen),
                Buffers::Multiple(elements) => elements.give_up_shared(seen),
            }
        }
    }

    /// Result of `look` for the last value read or written by codels.
    pub(crate) fn look<T>(
        &self,
        port: PortIx,
        element: Option<&str>,
        look: impl FnOnce(&Record) -> T,
    ) -> Option<T> {
        match (&self.ports.get(port)?.buffers, element) {
            (Buffers::Simple(buffer), None) => buffer.look(look),
            (Buffers::Multiple(elements), Some(name)) => elements.get(name.as_bytes())?.look(look),
            _ => None,
        }
    }

    /// The last value read or written by codels, if it was copied.
    pub(crate) fn last(&self, port: PortIx, element: Option<&str>) -> Option<Record> {
        match (&self.ports.get(port)?.buffers, element) {
            (Buffers::Simple(buffer), None) => buffer.last(),
            (Buffers::Multiple(elements), Some(name)) => elements.get(name.as_bytes())?.last(),
            _ => None,
        }
    }

    /// Puts back the last value of a port; an element of an out port is opened for it.
    pub(crate) fn restore(&self, port: PortIx, element: Option<&str>, value: &Record) {
        let Some(Handle { name, buffers, .. }) = self.ports.get(port) else { return };
        let restored = match (buffers, element) {
            (Buffers::Simple(buffer), None) => buffer.restore(value),
            (Buffers::Multiple(elements), Some(element)) => elements.restore(element, value),
            _ => return,
        };
        if let Err(failure) = restored {
            tracing::warn!("port {name}: its last value is not put back: {failure:?}");
        }
    }

    /// Publishes a value on a simple out port.
    pub(crate) fn write(&self, port: PortIx, value: &Record) {
        let Some(Handle { name, buffers: Buffers::Simple(buffer), .. }) = self.ports.get(port)
        else {
            return;
        };
        if let Err(failure) = buffer.write_value(value) {
            tracing::debug!("port {name}: not written: {failure:?}");
        }
    }
}
