//! One iceoryx2 node for a whole daemon, as a middleware.

use std::sync::Arc;

use genom_middleware::{
    Address, Capabilities, Client, DiscoverError, Endpoint, Middleware, OpenError, Policy,
    Publisher, Served, ServiceHandler, ServiceType, Subscription,
};
use genom_types::DataType;
use iceoryx2::prelude::*;

use crate::error::{BACKEND, ShmError};
use crate::ground::Ground;
use crate::inner::Inner;
use crate::options::Options;
use crate::raw::Ipc;
use crate::{calls, catalog, discover, publisher, subscription};

/// Writers that left whose samples a reader may still read; more than the samples that a reader
/// holds at a time.
const EXPIRED: usize = 4;

/// Ports over shared memory. Clones share the node.
#[derive(Clone)]
pub struct Shm {
    inner: Arc<Inner>,
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
        // Each costs a reader kilobytes of its own memory, used or not; ports have one writer.
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = EXPIRED;
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
        catalog::sweep(&node);
        Ok(Self { inner: Arc::new(Inner::new(Ground::new(node, options))) })
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
