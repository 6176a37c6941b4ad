//! The ports and services of one process, by address, and who has them open.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::convert::Infallible;
use std::sync::{Arc, Mutex};

use genom_middleware::describe::{type_of_port, types_of_service};
use genom_middleware::{
    Address, Backend, Capabilities, Client, DiscoverError, Discovery, Endpoint, EndpointKind,
    Middleware, OpenError, Policy, PortSpec, Ports, Publisher, Served, ServiceHandler, ServiceType,
    Services, Subscription,
};

use crate::exchange::{Exchange, MAX_DEPTH};
use crate::opened::{Opened, Port, lock};
use crate::options::Options;
use crate::ports::{LocalPublisher, LocalSubscription};
use crate::services::{LocalClient, LocalServed, Table};

/// Ports and services within this process. Clones share the same addresses.
#[derive(Clone, Default)]
pub struct Local {
    ports: Arc<Mutex<HashMap<Address, Port>>>,
    services: Arc<Table>,
}

impl Local {
    /// A middleware on which nothing is open.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Opens an end of a port. `end` makes it from the exchange and adds it to the port's counts.
    fn open<E>(
        &self,
        port: &PortSpec<'_>,
        kind: EndpointKind,
        end: impl FnOnce(&mut Port) -> Option<E>,
    ) -> Result<(E, Opened), OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let mut ports = lock(&self.ports);
        let port = match ports.entry(at.clone()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                new.insert(Port { exchange: Exchange::new(ty), writers: 0, readers: 0 })
            }
        };
        if !port.exchange.ty().same_as(ty) {
            return Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: type_of_port(ty),
                theirs: type_of_port(port.exchange.ty()),
            });
        }
        let end = end(port).ok_or_else(|| OpenError::Taken { address: at.clone() })?;
        drop(ports);
        Ok((end, Opened { ports: Arc::clone(&self.ports), at: at.clone(), kind }))
    }
}

impl Backend for Local {
    const NAME: &'static str = "local";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    type Options = Options;
    type Error = Infallible;

    fn open(_: Options) -> Result<Arc<dyn Middleware>, Infallible> {
        Ok(Arc::new(Self::new()))
    }
}

impl Middleware for Local {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: false,
            cross_host: false,
            services: true,
            native_services: false,
        }
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }
}

impl Ports for Local {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let (writer, opened) = self.open(port, EndpointKind::Publisher, |port| {
            let writer = port.exchange.writer()?;
            port.writers += 1;
            Some(writer)
        })?;
        Ok(Box::new(LocalPublisher { writer, _opened: opened }))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        if let Policy::Queue(depth) | Policy::Ring(depth) = policy
            && depth > MAX_DEPTH
        {
            return Err(OpenError::Unsupported {
                backend: Self::NAME.to_owned(),
                ty: port.ty.name().to_owned(),
                why: format!("a reader holds at most {MAX_DEPTH} samples, not {depth}"),
            });
        }
        let (reader, opened) = self.open(port, EndpointKind::Subscription, |port| {
            port.readers += 1;
            Some(port.exchange.reader(policy))
        })?;
        Ok(Box::new(LocalSubscription { reader, _opened: opened }))
    }
}

impl Services for Local {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        Ok(Box::new(LocalServed::open(&self.services, at, service, handler)?))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        Ok(Box::new(LocalClient::open(&self.services, at, service)?))
    }
}

impl Discovery for Local {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        let mut seen = Vec::new();
        for (address, port) in &*lock(&self.ports) {
            let ends = [
                (EndpointKind::Publisher, port.writers),
                (EndpointKind::Subscription, port.readers),
            ];
            for (kind, count) in ends {
                seen.extend((0..count).map(|_| Endpoint {
                    kind,
                    address: address.to_string(),
                    ty: port.exchange.ty().name().to_owned(),
                }));
            }
        }
        self.services.for_each(|address, service| {
            seen.push(Endpoint {
                kind: EndpointKind::Service,
                address: address.to_string(),
                ty: types_of_service(service),
            });
        });
        Ok(seen)
    }
}
