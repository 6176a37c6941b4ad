//! The addresses of one process, and who has them open.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex};

use genom_middleware::describe::{type_of_port, types_of_service};
use genom_middleware::{
    Address, Capabilities, Client, DiscoverError, Endpoint, EndpointKind, Middleware, OpenError,
    Policy, Publisher, Served, ServiceHandler, ServiceType, Subscription,
};
use genom_types::DataType;

use crate::exchange::{Exchange, MAX_DEPTH};
use crate::opened::{Opened, Port, lock};
use crate::ports::{LocalPublisher, LocalSubscription};
use crate::services::{LocalClient, LocalServed, Services};

/// Ports and services within this process. Clones share the same addresses.
#[derive(Clone, Default)]
pub struct Local {
    ports: Arc<Mutex<HashMap<Address, Port>>>,
    services: Arc<Services>,
}

impl Local {
    /// A middleware with no address in use.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Opens an end: `end` makes it from the exchange and says so in the port's counts.
    fn open<E>(
        &self,
        at: &Address,
        ty: &DataType,
        kind: EndpointKind,
        end: impl FnOnce(&mut Port) -> Option<E>,
    ) -> Result<(E, Opened), OpenError> {
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

impl Middleware for Local {
    fn name(&self) -> &'static str {
        "local"
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

    fn publisher(&self, at: &Address, ty: &DataType) -> Result<Box<dyn Publisher>, OpenError> {
        let (writer, opened) = self.open(at, ty, EndpointKind::Publisher, |port| {
            let writer = port.exchange.writer()?;
            port.writers += 1;
            Some(writer)
        })?;
        Ok(Box::new(LocalPublisher { writer, _opened: opened }))
    }

    fn subscription(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        if let Policy::Queue(depth) | Policy::Ring(depth) = policy
            && depth > MAX_DEPTH
        {
            return Err(OpenError::Unsupported {
                backend: self.name().to_owned(),
                ty: ty.name().to_owned(),
                why: format!("a reader holds at most {MAX_DEPTH} samples, not {depth}"),
            });
        }
        let (reader, opened) = self.open(at, ty, EndpointKind::Subscription, |port| {
            port.readers += 1;
            Some(port.exchange.reader(policy))
        })?;
        Ok(Box::new(LocalSubscription { reader, _opened: opened }))
    }

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
