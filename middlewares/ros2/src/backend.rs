//! The middleware as the daemon sees it.

use std::sync::Arc;

use genom_middleware::{
    Address, Backend, Capabilities, Client, DiscoverError, Discovery, Endpoint, Middleware,
    NoForeignName, Obstacle, OpenError, Refused, Served, ServiceHandler, ServiceType, Services,
};

use crate::core::Core;
use crate::error::{BACKEND, ParticipantError};
use crate::obstacles::obstacles;
use crate::options::Options;
use crate::services::ServiceEnds;

/// One DDS participant, with one ROS node per component instance.
#[derive(Clone)]
pub struct Ros2 {
    pub(crate) core: Arc<Core>,
    services: Arc<ServiceEnds>,
}

impl Ros2 {
    /// Joins a domain.
    ///
    /// # Errors
    /// An option is wrong, or DDS fails.
    pub fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        let core = Core::open(options)?;
        let services = ServiceEnds::new(Arc::clone(&core));
        Ok(Arc::new(Self { core, services }))
    }

    /// Blocks the out port that was opened first from sending until the result is dropped, so that
    /// tests can see how a stalled network affects real-time callers.
    #[doc(hidden)]
    #[must_use]
    pub fn stall(&self) -> impl Send + use<> {
        self.core.orders().stall()
    }
}

impl Backend for Ros2 {
    const NAME: &'static str = BACKEND;
    // The encodings have not changed since ROS 2 Iron.
    const VERSION: &'static str = "rustdds 0.15, ROS 2 Iron to Kilted";
    const GATEWAY: bool = true;
    type Options = Options;
    type Error = ParticipantError;

    fn check(options: &Options) -> Result<(), ParticipantError> {
        Ok(options.check()?)
    }

    fn open(options: Options) -> Result<Arc<dyn Middleware>, ParticipantError> {
        Ok(Self::open(&options)?)
    }
}

impl Middleware for Ros2 {
    fn name(&self) -> &'static str {
        BACKEND
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            variable_size: true,
            zero_copy: false,
            cross_process: true,
            cross_host: true,
            services: true,
            native_services: true,
        }
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }

    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        self.core.masquerades.add(ours, foreign)
    }

    fn unmask(&self, ours: &str) {
        self.core.masquerades.remove(ours);
    }

    fn refused(&self) -> Vec<Refused> {
        let refused = self.core.tally.list().into_iter();
        refused.map(|(why, count, peer)| Refused { why: why.text().into(), count, peer }).collect()
    }
}

impl Services for Ros2 {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        self.services.serve(at, service, handler)
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        self.services.client(at, service)
    }
}

impl Discovery for Ros2 {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        Ok(self.core.graph.list())
    }

    fn spelled(&self, at: &Address) -> String {
        self.core.full(at)
    }

    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        let core = &self.core;
        obstacles(&core.graph, &core.feeds, at, &format!("rt/{}", core.path(at)))
    }
}
