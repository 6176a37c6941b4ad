//! One iceoryx2 node for a whole daemon, and the services opened from it.

use std::sync::{Arc, Mutex, PoisonError};

use genom_middleware::describe::type_of_port;
use genom_middleware::{
    Address, Capabilities, Client, DiscoverError, Endpoint, Middleware, OpenError, Policy,
    Publisher, Served, ServiceHandler, ServiceType, Subscription,
};
use genom_types::DataType;
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError as Create, PublishSubscribeOpenError as Open,
};
use iceoryx2::service::static_config::StaticConfig;

use crate::attain::{Attempt, attain};
use crate::calls::{self, Worker};
use crate::error::ShmError;
use crate::options::Options;
use crate::raw::{self, Ipc, RawService};
use crate::typing::{MAX_NAME, Wire, wire};
use crate::upkeep::Upkeep;
use crate::{discover, publisher, subscription};

pub(crate) const BACKEND: &str = "shm";

/// Service attributes that say more of a type than iceoryx2 does.
pub(crate) const TYPE_KEY: &str = "genom.type";
pub(crate) const DIGEST_KEY: &str = "genom.digest";

/// Bytes of unread samples that a reader of large samples may hold.
const DEPTH_BYTES: usize = 16 << 20;

/// Ports over shared memory. Clones share the node.
#[derive(Clone)]
pub struct Shm {
    inner: Arc<Inner>,
}

pub(crate) struct Inner {
    /// Made when the first service is served or called.
    worker: Mutex<Option<Arc<Worker>>>,
    /// Its thread is stopped before the node goes.
    pub(crate) upkeep: Upkeep,
    pub(crate) ground: Arc<Ground>,
}

/// What services are opened from. Apart from [`Inner`], so that what the upkeep thread holds
/// never owns that thread.
pub(crate) struct Ground {
    pub(crate) node: Node<Ipc>,
    pub(crate) options: Options,
}

/// What a service is made for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Whether a full reader loses its oldest sample, or the new one.
    pub(crate) overflow: bool,
    /// Whether a reader that comes gets the last sample.
    pub(crate) history: bool,
    /// Unread samples a reader may hold.
    pub(crate) depth: usize,
}

impl Shm {
    /// Makes a node, and cleans up after processes that were killed.
    ///
    /// # Errors
    /// A name is not legal, or the folder of iceoryx2 cannot be used.
    pub fn open(options: Options) -> Result<Self, ShmError> {
        // Refusals come back as errors and are told by who asked; logging them too says it twice.
        iceoryx2::prelude::set_log_level(LogLevel::Fatal);
        let mut config = Config::global_config().clone();
        if let Some(prefix) = &options.prefix {
            config.global.prefix =
                FileName::new(prefix.as_bytes()).map_err(|_| ShmError::Prefix(prefix.clone()))?;
        }
        if let Some(root) = &options.root {
            let path = Path::new(root.as_os_str().as_encoded_bytes())
                .map_err(|_| ShmError::Root(root.clone()))?;
            config.global.set_root_path(&path);
        }
        let name =
            NodeName::new(&options.node).map_err(|_| ShmError::Node(options.node.clone()))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|error| ShmError::Create {
                root: config.global.root_path().to_string(),
                why: error.to_string(),
            })?;
        node.try_cleanup_dead_nodes();
        let ground = Arc::new(Ground { node, options });
        Ok(Self {
            inner: Arc::new(Inner { worker: Mutex::default(), upkeep: Upkeep::start(), ground }),
        })
    }
}

impl Inner {
    /// The thread that hands on requests and responses.
    pub(crate) fn worker(&self, at: &Address) -> Result<Arc<Worker>, OpenError> {
        let mut worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(worker) = &*worker {
            return Ok(Arc::clone(worker));
        }
        Ok(Arc::clone(worker.insert(Arc::new(Worker::start(&self.ground, at)?))))
    }
}

impl Ground {
    /// The shape of a port's own service.
    pub(crate) fn port(&self, wire: &Wire) -> Shape {
        let fits = if wire.slice { usize::MAX } else { DEPTH_BYTES / wire.size.max(1) };
        let depth = self.options.depth.clamp(2, fits.max(2));
        Shape { overflow: true, history: true, depth }
    }

    /// The name of a service, which iceoryx2 must like.
    pub(crate) fn service_name(name: &str, at: &Address) -> Result<ServiceName, OpenError> {
        ServiceName::new(name).map_err(|error| failed(at, &format!("illegal name: {error:?}")))
    }

    /// Opens the service, or creates it.
    pub(crate) fn service(
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
        let open = || {
            let builder = raw::builder(&self.node, &name, &wire, false).ok_or_else(too_long)?;
            match builder.open() {
                Ok(service) => self.agree(at, ty, service).map(Attempt::Done),
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
        attain(self, at, open, create)
    }

    /// Two types of one name and size may still differ: the digests tell.
    fn agree(
        &self,
        at: &Address,
        ty: &DataType,
        service: RawService,
    ) -> Result<RawService, OpenError> {
        match attribute(service.attributes(), DIGEST_KEY) {
            Some(digest) if digest != ty.digest() => Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: type_of_port(ty),
                theirs: describe(
                    service.attributes(),
                    service.static_config().message_type_details().payload,
                ),
            }),
            _ => Ok(service),
        }
    }

    fn mismatch(&self, at: &Address, name: &ServiceName, ty: &DataType) -> Option<OpenError> {
        let details =
            <Ipc as Service>::details(name, self.node.config(), MessagingPattern::PublishSubscribe);
        let theirs = type_of_service(&details.ok()??.static_details);
        Some(OpenError::TypeMismatch { address: at.clone(), ours: type_of_port(ty), theirs })
    }
}

pub(crate) fn failed(at: &Address, why: &str) -> OpenError {
    OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why: why.to_owned() }
}

/// What a service of ours says of its types. A spelling that does not fit is left out: the digest
/// decides.
pub(crate) fn attributes(pairs: [(&str, &str); 2]) -> AttributeSpecifier {
    let mut attributes = AttributeSpecifier::new();
    for (key, value) in pairs {
        if let (Ok(key), Ok(value)) = (key.try_into(), value.try_into())
            && let Ok(more) = attributes.clone().define(&key, &value)
        {
            attributes = more;
        }
    }
    attributes
}

pub(crate) fn attribute(attributes: &AttributeSet, key: &str) -> Option<String> {
    let key = key.try_into().ok()?;
    attributes.key_value(&key, 0).map(ToString::to_string)
}

/// The type of a service, whoever made it.
pub(crate) fn type_of_service(service: &StaticConfig) -> String {
    describe(service.attributes(), service.publish_subscribe().message_type_details().payload)
}

fn describe(
    attributes: &AttributeSet,
    payload: iceoryx2::service::static_config::message_type_details::TypeDetail,
) -> String {
    let layout = format!("{} bytes aligned to {}", payload.size(), payload.alignment());
    match (attribute(attributes, TYPE_KEY), attribute(attributes, DIGEST_KEY)) {
        (Some(ty), Some(digest)) => format!("{ty} ({layout}, digest {digest})"),
        _ => format!("the iceoryx2 type {} ({layout})", payload.type_name()),
    }
}

impl Middleware for Shm {
    fn name(&self) -> &'static str {
        BACKEND
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: true,
            cross_host: false,
            services: true,
            native_services: true,
        }
    }

    fn meeting_point(&self) -> Vec<(&'static str, String)> {
        let config = &self.inner.ground.node.config().global;
        vec![("prefix", config.prefix.to_string()), ("root", config.root_path().to_string())]
    }

    fn publisher(&self, at: &Address, ty: &DataType) -> Result<Box<dyn Publisher>, OpenError> {
        Ok(Box::new(publisher::open(&self.inner, at, ty)?))
    }

    fn subscription(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        Ok(Box::new(subscription::open(&self.inner, at, ty, policy)?))
    }

    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        Ok(Box::new(calls::serve(&self.inner, at, service, handler)?))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        Ok(Box::new(calls::client(&self.inner, at, service)?))
    }

    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        discover::list(&self.inner.ground.node)
    }
}
