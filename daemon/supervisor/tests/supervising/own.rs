//! A middleware that the test provides: exchanges within the process, and notes the quality of
//! service that ports are opened with.

use std::sync::{Arc, Mutex};

use genom_local::Local;
use genom_middleware::{
    Capabilities, Discovery, Middleware, OpenError, Policy, PortSpec, Ports, Publisher, Quality,
    Services, Subscription,
};

/// End, name of the port, and requested quality of service.
pub(crate) type Opened = (&'static str, String, Quality);

pub(crate) struct Own {
    local: Local,
    opened: Mutex<Vec<Opened>>,
}

impl Own {
    pub(crate) fn new() -> Arc<Self> {
        Arc::new(Self { local: Local::new(), opened: Mutex::default() })
    }

    /// The ends that were opened at an address.
    pub(crate) fn opened(&self, address: &str) -> Vec<Opened> {
        let all = self.opened.lock().unwrap();
        all.iter().filter(|(_, at, _)| at == address).cloned().collect()
    }

    fn note(&self, end: &'static str, port: &PortSpec<'_>) {
        self.opened.lock().unwrap().push((end, port.address.to_string(), port.quality));
    }
}

impl Ports for Own {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        self.note("publisher", port);
        self.local.publisher(port)
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        self.note("subscription", port);
        self.local.subscription(port, policy)
    }
}

impl Middleware for Own {
    fn name(&self) -> &'static str {
        "own"
    }

    fn capabilities(&self) -> Capabilities {
        self.local.capabilities()
    }

    fn services(&self) -> Option<&dyn Services> {
        self.local.services()
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        self.local.discovery()
    }
}
