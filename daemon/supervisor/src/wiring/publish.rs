//! Publishers of out ports: opened at load, and by codels for elements of multiple ports.

use std::sync::{Arc, Weak};

use genom_description::model::PortDirection;
use genom_middleware::{Address, OpenError, PortSpec, Publisher, Quality};
use genom_ports::{Ends, Fan};
use genom_runtime::HeldUp;
use genom_runtime::body::{Body, Opener};
use genom_runtime::plan::Plan;
use genom_types::DataType;

use crate::daemon::Daemon;
use crate::limits;
use crate::wires::Wires;
use genom_configuration::BackendNames;
use genom_registry::BackendError;

/// A port could not be opened on one of its middlewares.
#[derive(Debug, thiserror::Error)]
pub enum BindError {
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused.
    #[error("{source}{limit}")]
    Open {
        /// Its own words.
        source: Box<OpenError>,
        /// The limit of the system that was reached, if one was.
        limit: String,
    },
    /// A codel does not return: of the component, or of one that reads it.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

impl From<Box<OpenError>> for BindError {
    /// Looks at limits while what was opened before still is.
    fn from(source: Box<OpenError>) -> Self {
        Self::Open { source, limit: limits::reached() }
    }
}

/// Opens an address on each of these middlewares, in this quality.
pub(super) fn open(
    daemon: &Daemon,
    names: &BackendNames,
    address: &Address,
    ty: &DataType,
    quality: &Quality,
) -> Result<Ends, BindError> {
    let mut ends = Vec::with_capacity(names.names().len());
    for name in names.names() {
        let middleware = daemon.backends.get(name)?;
        let publisher =
            middleware.publisher(&PortSpec::new(address, ty).of(*quality)).map_err(Box::new)?;
        ends.push((name.clone(), publisher));
    }
    Ok(ends)
}

/// Opens every out port of an instance that does not run yet.
pub fn bind(
    daemon: &Arc<Daemon>,
    body: &dyn Body,
    plan: &Arc<Plan>,
    instance: &str,
    wires: &Arc<Wires>,
) -> Result<(), BindError> {
    for (index, port) in plan.component().ports.iter().enumerate() {
        if port.direction == PortDirection::Out
            && !port.multiple
            && let Some(ty) = plan.port_type(index)
        {
            let address = Address::new(instance, port.name.as_str());
            let (names, quality) =
                (wires.bindings.port(&port.name), wires.bindings.quality(&port.name));
            let ends = open(daemon, &names, &address, ty, &quality)?;
            let fan = Fan::new(ends, &daemon.clock, ty);
            body.bind_out(index, None, Some(fan.publisher()));
            wires.opened(index, None, fan.clone());
            daemon.recordings.opened(&address, PortDirection::Out, None, ty, fan.tapes());
        }
    }
    body.set_opener(Box::new(ElementOpener {
        daemon: Arc::downgrade(daemon),
        instance: instance.to_owned(),
        plan: Arc::clone(plan),
        wires: Arc::clone(wires),
    }));
    Ok(())
}

/// Opens elements of multiple out ports under `<instance>/<port>/<element>` (genom3.md 7.8).
struct ElementOpener {
    /// Weak: the daemon owns the instances, not the other way round.
    daemon: Weak<Daemon>,
    instance: String,
    plan: Arc<Plan>,
    wires: Arc<Wires>,
}

impl Opener for ElementOpener {
    fn open(&self, port: usize, element: &str) -> Result<Box<dyn Publisher>, String> {
        let known = self.plan.component().ports.get(port).zip(self.plan.port_type(port));
        let Some((model, ty)) = known else {
            return Err(format!("{} has no port number {port}", self.instance));
        };
        let Some(daemon) = self.daemon.upgrade() else {
            return Err("the daemon stops".to_owned());
        };
        let name = &model.name;
        if element.split('/').any(str::is_empty) {
            return Err(format!("`{element}` cannot name an element of {name}"));
        }
        let address = Address::new(self.instance.as_str(), format!("{name}/{element}"));
        let names = self.wires.bindings.port(name);
        let quality = self.wires.bindings.quality(name);
        let ends = open(&daemon, &names, &address, ty, &quality);
        let ends = ends.map_err(|error| error.to_string())?;
        let fan = Fan::new(ends, &daemon.clock, ty);
        let publisher = fan.publisher();
        self.wires.opened(port, Some(element), fan.clone());
        daemon.recordings.opened(&address, PortDirection::Out, None, ty, fan.tapes());
        Ok(publisher)
    }

    fn close(&self, port: usize, element: &str) {
        self.wires.closed(port, element);
    }
}
