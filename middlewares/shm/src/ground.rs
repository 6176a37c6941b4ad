//! What the services of ports are opened from, and with which settings.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, Endpoint, EndpointKind, OpenError};
use genom_types::DataType;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError as Create, PublishSubscribeOpenError as Open,
};

use crate::attain::{Attempt, attain};
use crate::attributes::{DIGEST_KEY, TYPE_KEY, attribute, attributes, describe, type_of_service};
use crate::catalog::{self, Catalog, CatalogError, Kind, Offer, Reader};
use crate::error::{BACKEND, failed};
use crate::options::Options;
use crate::raw::{self, Ipc, RawPublisher, RawService};
use crate::typing::{MAX_NAME, Wire, wire};
use crate::watch::Watcher;

/// Limit for the unread samples of one reader, in bytes; large samples get a smaller queue.
const DEPTH_BYTES: usize = 16 << 20;

/// Initial size in bytes for values of variable size; doubles when needed.
const FIRST_ROOM: usize = 1024;

/// Bytes of sample memory preallocated beyond what is always needed.
const SAMPLE_BYTES: usize = 4 << 20;

/// What services are opened from. Separate from `Inner`, so that the upkeep thread, which holds
/// this, never owns itself.
pub(crate) struct Ground {
    /// What this daemon offers; created with the first offer. Dropped before the node.
    catalog: Mutex<Option<Catalog>>,
    /// What other daemons offer.
    others: Mutex<Reader>,
    /// Open services. The ends of one port in this daemon share a service, and thereby its file
    /// descriptors.
    services: Mutex<HashMap<String, Weak<RawService>>>,
    pub(crate) node: Node<Ipc>,
    pub(crate) options: Options,
    pub(crate) watcher: Watcher,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Settings with which a service is created.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// When a reader's queue is full: true drops its oldest sample, false the new one.
    pub(crate) overflow: bool,
    /// Whether a new reader gets the last sample.
    pub(crate) history: bool,
    /// Greatest number of unread samples of one reader.
    pub(crate) depth: usize,
}

impl Ground {
    /// Nothing is open yet.
    pub(crate) fn new(node: Node<Ipc>, options: Options, watcher: Watcher) -> Self {
        let (catalog, others, services) = (Mutex::default(), Mutex::default(), Mutex::default());
        Self { catalog, others, services, node, options, watcher }
    }

    /// Announces that this daemon offers something at an address, unless the address is taken.
    pub(crate) fn offer(&self, kind: Kind, at: &Address, offer: Offer) -> Result<(), OpenError> {
        let (address, taken) = (at.to_string(), || OpenError::Taken { address: at.clone() });
        let refused = |error: CatalogError| failed(at, &error.to_string());
        let mut catalog = lock(&self.catalog);
        let own = match &mut *catalog {
            Some(own) => own,
            none => none.insert(Catalog::create(&self.node).map_err(refused)?),
        };
        if !own.add(kind, &address, offer).map_err(refused)? {
            return Err(taken());
        }
        // Check after announcing: of two daemons that announce at the same time, at most one keeps
        // it.
        if lock(&self.others).is_of_others(&self.node, kind, &address) {
            own.remove(kind, &address);
            return Err(taken());
        }
        Ok(())
    }

    /// Withdraws an offer.
    pub(crate) fn withdraw(&self, kind: Kind, at: &Address) {
        if let Some(own) = &mut *lock(&self.catalog) {
            own.remove(kind, &at.to_string());
        }
    }

    /// The daemons that offer something at an address, including killed ones.
    pub(crate) fn find(&self, kind: Kind, at: &Address) -> Vec<(u128, Offer)> {
        lock(&self.others).find(&self.node, kind, &at.to_string())
    }

    /// What living daemons offer at an address, as endpoints.
    pub(crate) fn offered(&self, kind: Kind, at: &Address) -> Vec<Endpoint> {
        let mut found = self.find(kind, at);
        if found.is_empty() {
            return Vec::new();
        }
        let alive = catalog::alive(&self.node);
        found.retain(|(owner, _)| alive.contains(owner));
        let kind = match kind {
            Kind::Service => EndpointKind::Service,
            Kind::Writer => EndpointKind::Publisher,
        };
        let end = |offer: Offer| Endpoint { kind, address: at.to_string(), ty: offer.spelling };
        found.into_iter().map(|(_, offer)| end(offer)).collect()
    }

    /// The settings of a port's own service.
    pub(crate) fn port(&self, wire: &Wire) -> Shape {
        let fits = if wire.slice { usize::MAX } else { DEPTH_BYTES / wire.size.max(1) };
        let depth = self.options.depth.clamp(2, fits.max(2));
        Shape { overflow: true, history: true, depth }
    }

    /// The name as an iceoryx2 service name.
    pub(crate) fn service_name(name: &str, at: &Address) -> Result<ServiceName, OpenError> {
        ServiceName::new(name).map_err(|error| failed(at, &format!("illegal name: {error:?}")))
    }

    /// Opens or creates the service; reuses it if this daemon has it open.
    pub(crate) fn service(
        &self,
        at: &Address,
        name: &str,
        ty: &DataType,
        shape: Shape,
    ) -> Result<Arc<RawService>, OpenError> {
        let mut services = lock(&self.services);
        if let Some(open) = services.get(name).and_then(Weak::upgrade)
            && attribute(open.attributes(), DIGEST_KEY).is_some()
        {
            self.agree(at, ty, &open)?;
            return Ok(open);
        }
        let service = Arc::new(self.new_service(at, name, ty, shape)?);
        services.retain(|_, service| service.strong_count() > 0);
        services.insert(name.to_owned(), Arc::downgrade(&service));
        Ok(service)
    }

    fn new_service(
        &self,
        at: &Address,
        name: &str,
        ty: &DataType,
        shape: Shape,
    ) -> Result<RawService, OpenError> {
        let (name, wire) = (Self::service_name(name, at)?, wire(ty));
        let too_long = || OpenError::Unsupported {
            backend: BACKEND.to_owned(),
            ty: ty.name().to_owned(),
            why: format!("its name is longer than {MAX_NAME} characters"),
        };
        let attempt = |wire: &Wire| {
            let builder = raw::builder(&self.node, &name, wire, false).ok_or_else(too_long)?;
            Ok(builder.open())
        };
        let open = || {
            let mut opened = attempt(&wire)?;
            if let Err(Open::IncompatibleTypes) = opened
                && let Some(theirs) = self.equal(&name, ty, &wire)
            {
                opened = attempt(&theirs)?;
            }
            match opened {
                Ok(service) => self.agree(at, ty, &service).map(|()| Attempt::Done(service)),
                Err(Open::DoesNotExist) => Ok(Attempt::Absent),
                Err(Open::IncompatibleTypes) => match self.mismatch(at, &name, ty) {
                    Some(mismatch) => Err(mismatch),
                    None => Ok(Attempt::Busy("it changes all the time".to_owned())),
                },
                Err(
                    error @ (Open::IsMarkedForDestruction
                    | Open::HangsInCreation
                    | Open::ServiceInCorruptedState),
                ) => Ok(Attempt::Broken(error.to_string())),
                Err(error) => Err(failed(at, &error.to_string())),
            }
        };
        let create = || {
            let builder = raw::builder(&self.node, &name, &wire, true).ok_or_else(too_long)?;
            let create = builder
                .enable_safe_overflow(shape.overflow)
                .history_size(usize::from(shape.history))
                .subscriber_max_buffer_size(shape.depth)
                .subscriber_max_borrowed_samples(2)
                .max_publishers(1)
                .max_subscribers(self.options.readers)
                .max_nodes(self.options.readers + 20)
                .create_with_attributes(&attributes([
                    (DIGEST_KEY, ty.digest()),
                    (TYPE_KEY, ty.name()),
                ]));
            match create {
                Ok(service) => Ok(Attempt::Done(service)),
                Err(
                    error @ (Create::AlreadyExists
                    | Create::IsBeingCreatedByAnotherInstance
                    | Create::HangsInCreation),
                ) => Ok(Attempt::Busy(error.to_string())),
                Err(error) => Err(failed(at, &error.to_string())),
            }
        };
        attain(self.keeping(), at, open, create)
    }

    /// The thread that heals what is broken, and how many bytes of shared memory must stay free.
    pub(crate) fn keeping(&self) -> (&Watcher, u64) {
        (&self.watcher, self.options.keep_free)
    }

    /// Compares digests: two types of the same name and size may still differ.
    fn agree(&self, at: &Address, ty: &DataType, service: &RawService) -> Result<(), OpenError> {
        match attribute(service.attributes(), DIGEST_KEY) {
            Some(digest) if digest != ty.digest() => Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: type_of_port(ty),
                theirs: describe(
                    service.attributes(),
                    service.static_config().message_type_details().payload,
                ),
            }),
            _ => Ok(()),
        }
    }

    /// The wire type with which to open a service that was created for an equal type of another
    /// name, such as a type with the same members in another component's module (genom3.md 4.9).
    fn equal(&self, name: &ServiceName, ty: &DataType, wire: &Wire) -> Option<Wire> {
        let details =
            <Ipc as Service>::details(name, self.node.config(), MessagingPattern::PublishSubscribe);
        let service = details.ok()??.static_details;
        let payload = service.publish_subscribe().message_type_details().payload;
        let equal = attribute(service.attributes(), DIGEST_KEY)? == ty.digest()
            && payload.size() == wire.size
            && payload.alignment().is_multiple_of(wire.align);
        equal.then(|| Wire { name: payload.type_name().to_string(), ..wire.clone() })
    }

    fn mismatch(&self, at: &Address, name: &ServiceName, ty: &DataType) -> Option<OpenError> {
        let details =
            <Ipc as Service>::details(name, self.node.config(), MessagingPattern::PublishSubscribe);
        let theirs = type_of_service(&details.ok()??.static_details);
        Some(OpenError::TypeMismatch { address: at.clone(), ours: type_of_port(ty), theirs })
    }

    /// Creates the publisher of a service; a service has only one.
    pub(crate) fn writer(
        &self,
        at: &Address,
        service: &RawService,
        wire: &Wire,
    ) -> Result<RawPublisher, OpenError> {
        let taken = || OpenError::Taken { address: at.clone() };
        if service.dynamic_config().number_of_publishers() > 0 {
            return Err(taken());
        }
        // Enough samples for one reader that never reads, one held by each other reader, the last
        // value and the one being written. Small types get enough for all readers never to read.
        let depth = service.static_config().subscriber_max_buffer_size();
        let needed = depth + self.options.readers + 4;
        let affordable = SAMPLE_BYTES / if wire.slice { FIRST_ROOM } else { wire.size.max(64) };
        let limit = if wire.slice { needed } else { needed.max(affordable) };
        let builder = service
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .override_sample_preallocation(move |worst| worst.min(limit));
        let builder = if wire.slice {
            builder
                .initial_max_slice_len(FIRST_ROOM)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
        } else {
            builder
        };
        builder.create().map_err(|error| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => taken(),
            other => failed(at, &other.to_string()),
        })
    }
}
