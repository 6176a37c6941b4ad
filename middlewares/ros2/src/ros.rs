//! What is ROS on every middleware: names, namespaces and types of ports and services.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, EndpointKind, OpenError};
use genom_rosidl::TypeName;
use genom_types::DataType;

use crate::error::BACKEND;
use crate::masquerades::Masquerades;
use crate::names::Names;
use crate::options::Options;
use crate::rmw::{Named, Rmw, Wanted};
use crate::used::{Used, hash};

/// Kept alive by services.
pub(crate) struct Ros {
    pub(crate) rmw: Arc<dyn Rmw>,
    pub(crate) options: Options,
    pub(crate) names: Names,
    pub(crate) masquerades: Arc<Masquerades>,
    /// Whether the time of components is that of a simulator.
    simulated: AtomicBool,
}

impl Ros {
    pub(crate) fn new(rmw: Arc<dyn Rmw>, options: &Options) -> Arc<Self> {
        let masquerades = Arc::new(Masquerades::new(options));
        let names = Names::new(&options.namespace);
        let (options, simulated) = (options.clone(), AtomicBool::new(false));
        Arc::new(Self { rmw, options, names, masquerades, simulated })
    }

    /// From now on, the time of components is that of a simulator.
    pub(crate) fn simulate(&self) {
        self.simulated.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_simulated(&self) -> bool {
        self.simulated.load(Ordering::Relaxed)
    }

    /// A topic or service of a type of ROS's own.
    pub(crate) fn of_ros(&self, name: String, ty: TypeName) -> Named {
        let hash = hash(self.masquerades.of_ros(&ty).as_ref());
        Named { name, ty, hash }
    }

    /// What an end of a port wants, and the type of its messages.
    pub(crate) fn port(
        &self,
        kind: EndpointKind,
        at: &Address,
        ty: &DataType,
    ) -> Result<(Wanted, Option<Arc<Used>>), OpenError> {
        let message = self.masquerades.message(ty).map_err(|why| failed(at, why))?;
        let used = self.masquerades.of_port(ty);
        let wanted = Wanted {
            kind,
            address: self.names.full(at),
            types: type_of_port(ty),
            digest: ty.digest().to_owned(),
            of: Named { name: self.names.path(at), ty: message, hash: hash(used.as_ref()) },
            node: match kind {
                // The address is the writer's; which component reads is not known here.
                EndpointKind::Subscription => self.names.own_node(),
                _ => self.names.node(&at.instance),
            },
        };
        Ok((wanted, used))
    }
}

pub(crate) fn failed(at: &Address, why: impl std::fmt::Display) -> OpenError {
    OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why: why.to_string() }
}
