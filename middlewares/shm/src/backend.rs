//! The middleware: one iceoryx2 node per daemon.

use std::borrow::Cow;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use genom_middleware::{
    Address, Backend, Capabilities, Client, DiscoverError, Discovery, Endpoint, Middleware,
    OpenError, Policy, PortSpec, Ports, Publisher, Served, ServiceHandler, ServiceType, Services,
    Subscription,
};
use iceoryx2::prelude::*;

use crate::calls::Desk;
use crate::error::{BACKEND, ShmError};
use crate::ground::Ground;
use crate::heal::{self, Places, Turn};
use crate::inner::Inner;
use crate::options::Options;
use crate::raw::Ipc;
use crate::watch::Watch;
use crate::{calls, discover, publisher, rights, subscription};

/// How long iceoryx2 itself waits for a service that another process is creating.
const CREATION: Duration = Duration::from_millis(100);

/// Greatest number of former writers whose samples a reader may still read; more than the samples
/// that a reader holds at a time.
const EXPIRED: usize = 4;

/// Ports over shared memory. Clones share the node.
#[derive(Clone)]
pub struct Shm {
    inner: Arc<Inner>,
    calls: Arc<Desk>,
}

impl Shm {
    /// Creates the node, and removes what killed processes left behind.
    ///
    /// # Errors
    /// A name is not valid, or iceoryx2's folder cannot be used.
    pub fn open(options: Options) -> Result<Self, ShmError> {
        options.check()?;
        let mut config = installed().clone();
        let told = rights::is_told(&config);
        let prefix = options.prefix.clone().or((!told).then(rights::default_prefix));
        let root = options.root.clone().or((!told).then(rights::default_root));
        if let Some(prefix) = &prefix {
            config.global.prefix =
                FileName::new(prefix.as_bytes()).map_err(|_| ShmError::Prefix(prefix.clone()))?;
        }
        if let Some(root) = &root {
            let path = Path::new(root.as_os_str().as_encoded_bytes())
                .map_err(|_| ShmError::Root(root.clone()))?;
            config.global.set_root_path(&path);
        }
        // Each entry costs a reader kilobytes of memory whether it is used or not, and a port has
        // only one writer.
        config.defaults.publish_subscribe.subscriber_expired_connection_buffer = EXPIRED;
        let name =
            NodeName::new(&options.node).map_err(|_| ShmError::Node(options.node.clone()))?;
        // `heal` does this, since it recognises more kinds of remains. Only one of the two may do
        // it in a process: closing a file gives up the POSIX lock that another thread holds on it.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        // Living processes need far less time to create a service; after this, `heal` checks it.
        config.global.creation_timeout = CREATION;
        let places = Places::of(&config);
        rights::prepare(&places)?;
        let watch = Watch::start(&config);
        let watcher = watch.watcher().clone();
        let node = {
            let _busy = watcher.busy();
            let unusable = |error: io::Error| ShmError::Folder {
                path: places.root.clone(),
                why: error.to_string(),
            };
            let turn = Turn::take(&places.root).map_err(unusable)?;
            heal::heal(&config, &places, &turn);
            let node = NodeBuilder::new()
                .name(&name)
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<Ipc>()
                .map_err(|error| ShmError::Create {
                    root: config.global.root_path().to_string(),
                    why: error.to_string(),
                })?;
            rights::close(&places).map_err(unusable)?;
            node
        };
        let ground = Ground::new(node, options, watcher);
        let inner = Arc::new(Inner::new(ground, watch));
        Ok(Self { calls: Desk::new(&inner), inner })
    }
}

/// iceoryx2's own configuration, which is read once.
fn installed() -> &'static Config {
    // Errors are returned, and the caller reports them; iceoryx2's log would repeat them, and say
    // that there is no configuration file where none is needed.
    iceoryx2::prelude::set_log_level(LogLevel::Fatal);
    Config::global_config()
}

impl Backend for Shm {
    const NAME: &'static str = BACKEND;
    const VERSION: &'static str = "iceoryx2 0.10";
    type Options = Options;
    type Error = ShmError;

    fn check(options: &Options) -> Result<(), ShmError> {
        options.check()
    }

    fn places(options: &Options) -> Vec<PathBuf> {
        // Read now, as it may be out of reach later.
        let config = installed();
        let told = rights::is_told(config).then(|| config.global.root_path().to_string().into());
        let root = options.root.clone().or(told);
        vec![root.unwrap_or_else(rights::default_root), PathBuf::from(heal::SEGMENTS)]
    }

    fn open(options: Options) -> Result<Arc<dyn Middleware>, ShmError> {
        Ok(Arc::new(Self::open(options)?))
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

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        let config = &self.inner.ground.node.config().global;
        vec![
            ("prefix".into(), config.prefix.to_string()),
            ("root".into(), config.root_path().to_string()),
        ]
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }
}

impl Ports for Shm {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let _busy = self.inner.ground.watcher.busy();
        Ok(Box::new(publisher::open(&self.inner, port.address, port.ty)?))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let _busy = self.inner.ground.watcher.busy();
        Ok(Box::new(subscription::open(&self.inner, port.address, port.ty, policy)?))
    }
}

impl Services for Shm {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let _busy = self.inner.ground.watcher.busy();
        Ok(Box::new(calls::serve(&self.calls, at, service, handler)?))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let _busy = self.inner.ground.watcher.busy();
        Ok(Box::new(calls::client(&self.calls, at, service)?))
    }
}

impl Discovery for Shm {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        let _busy = self.inner.ground.watcher.busy();
        let _ = self.inner.ground.watcher.heal_dead();
        discover::list(&self.inner.ground.node)
    }

    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let _busy = self.inner.ground.watcher.busy();
        let _ = self.inner.ground.watcher.heal_dead();
        Ok(discover::at(&self.inner.ground, at))
    }
}
