//! Opens publishers of out ports, when a component is loaded and when codels open elements of
//! multiple ports.

use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_description::model::{PortDirection, PortIx};
use genom_middleware::{Address, OpenError, PortSpec, Publisher, Quality};
use genom_ports::{Ends, Fan, Needs, PortKey};
use genom_registry::{BackendError, Backends};
use genom_runtime::body::{Body, ElementError, Opener};
use genom_runtime::plan::Plan;
use genom_runtime::{Clock, HeldUp};
use genom_types::DataType;

use crate::components::Hosted;
use crate::limits;
use crate::recording::Recordings;
use crate::ties::Ties;

/// Why a port could not be opened on one of its middlewares.
#[derive(Debug, thiserror::Error)]
pub enum BindError {
    /// There is no such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware reported an error.
    #[error("{source}{limit}")]
    Open {
        /// The error of the middleware.
        source: Box<OpenError>,
        /// The limit of the system that was reached, as a part of the message; empty if none was.
        limit: String,
    },
    /// A codel of the component, or of a reader of the port, does not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

impl From<Box<OpenError>> for BindError {
    /// Checks the limits now, while what was opened before is still open.
    fn from(source: Box<OpenError>) -> Self {
        Self::Open { source, limit: limits::reached() }
    }
}

/// What is needed to open publishers of ports.
#[derive(Clone)]
pub struct Opening {
    pub(crate) backends: Arc<Backends>,
    pub(crate) recordings: Arc<Recordings>,
    /// The clock of the components.
    pub(crate) clock: Clock,
    /// The ends that connections need.
    pub(crate) needs: Arc<Needs>,
}

/// An out port that was opened.
struct Open {
    fan: Fan,
    /// Middlewares on which it is only as long as connections need that.
    lent: Vec<String>,
}

impl Opening {
    /// Opens an address on each of these middlewares, with this quality of service.
    pub(super) fn ends(
        &self,
        names: &BackendNames,
        address: &Address,
        ty: &DataType,
        quality: Quality,
    ) -> Result<Ends, BindError> {
        let mut ends = Vec::with_capacity(names.names().len());
        for name in names.names() {
            let middleware = self.backends.get(name)?;
            let port = PortSpec::new(address, ty).of(quality);
            let publisher = middleware.publisher(&port).map_err(Box::new)?;
            ends.push((name.clone(), publisher));
        }
        Ok(ends)
    }

    /// Opens an out port on its middlewares, and on those over which connections read it already.
    fn fan(
        &self,
        ties: &Ties,
        address: &Address,
        port: &str,
        ty: &DataType,
    ) -> Result<Open, BindError> {
        let (names, quality) = (ties.bindings.port(port), ties.bindings.quality(port));
        let mut ends = self.ends(&names, address, ty, quality)?;
        let mut lent = Vec::new();
        for over in self.needs.of(address).into_iter().filter(|over| !names.has(over)) {
            match self.ends(&BackendNames::one(over.as_str()), address, ty, quality) {
                Ok(more) => {
                    ends.extend(more);
                    lent.push(over);
                }
                // Tried again later: it is no reason not to run the component.
                Err(error) => tracing::warn!("a connection reads {address} over {over}: {error}"),
            }
        }
        Ok(Open { fan: Fan::new(ends, &self.clock, ty), lent })
    }

    /// A publisher for a port that is open elsewhere.
    fn nowhere(&self, ty: &DataType) -> Box<dyn Publisher> {
        Fan::new(Vec::new(), &self.clock, ty).publisher()
    }

    /// Opens an out port of a component that runs, in place of one of another type.
    pub(crate) fn open_again(&self, hosted: &Hosted, port: PortIx) -> Result<(), BindError> {
        let Some(ty) = hosted.port_type(port) else { return Ok(()) };
        let key = PortKey::new(port, None);
        let address = hosted.port_address(&key);
        let open = self.fan(&hosted.ties, &address, &hosted.model().ports[port].name, ty)?;
        hosted.bind_out(&key, open.fan.publisher())?;
        self.opened(&hosted.ties, key, &address, ty, open);
        Ok(())
    }

    /// Registers an open port with supervisors and recordings.
    fn opened(&self, ties: &Ties, key: PortKey, address: &Address, ty: &DataType, open: Open) {
        ties.opened(key, open.fan.clone(), open.lent);
        self.recordings.opened(address, PortDirection::Out, None, ty, open.fan.tapes());
    }

    /// Opens every out port of an instance that is not running yet.
    pub(crate) fn bind(
        &self,
        body: &dyn Body,
        plan: &Arc<Plan>,
        instance: &str,
        ties: &Arc<Ties>,
    ) -> Result<(), BindError> {
        for (index, port) in plan.component().ports.pairs() {
            if port.direction == PortDirection::Out
                && !port.multiple
                && let Some(ty) = plan.port_type(index)
            {
                if ties.is_promised(&port.name) {
                    body.bind_out(index, None, Some(self.nowhere(ty)));
                    continue;
                }
                let address = Address::new(instance, port.name.as_str());
                let open = self.fan(ties, &address, &port.name, ty)?;
                body.bind_out(index, None, Some(open.fan.publisher()));
                self.opened(ties, PortKey::new(index, None), &address, ty, open);
            }
        }
        body.set_opener(Box::new(ElementOpener {
            opening: self.clone(),
            instance: instance.to_owned(),
            plan: Arc::clone(plan),
            ties: Arc::clone(ties),
        }));
        Ok(())
    }
}

/// Opens elements of multiple out ports under `<instance>/<port>/<element>` (genom3.md 7.8).
struct ElementOpener {
    opening: Opening,
    instance: String,
    plan: Arc<Plan>,
    ties: Arc<Ties>,
}

impl Opener for ElementOpener {
    fn open(&self, port: PortIx, element: &str) -> Result<Box<dyn Publisher>, ElementError> {
        let known = self.plan.component().ports.get(port).zip(self.plan.port_type(port));
        let Some((model, ty)) = known else {
            return Err(ElementError::NoSuchPort { instance: self.instance.clone(), port });
        };
        let name = &model.name;
        if element.split('/').any(str::is_empty) {
            let (element, port) = (element.to_owned(), name.clone());
            return Err(ElementError::Name { element, port });
        }
        let local = format!("{name}/{element}");
        if self.ties.is_promised(&local) {
            return Ok(self.opening.nowhere(ty));
        }
        let address = Address::new(self.instance.as_str(), local);
        let open = self.opening.fan(&self.ties, &address, name, ty);
        let open = open.map_err(|error| ElementError::Open(Box::new(error)))?;
        let key = PortKey::new(port, Some(element));
        let publisher = open.fan.publisher();
        self.opening.opened(&self.ties, key, &address, ty, open);
        Ok(publisher)
    }

    fn close(&self, port: PortIx, element: &str) {
        self.ties.closed(&PortKey::new(port, Some(element)));
    }
}
