//! A middleware that the test provides: exchanges within the process, notes the quality of service
//! that ports are opened with, and counts how often everything is listed.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use genom_local::Local;
use genom_middleware::{
    Address, Capabilities, DiscoverError, Discovery, Endpoint, Middleware, OpenError, Policy,
    PortSpec, Ports, Publisher, Quality, Services, Subscription,
};

/// End, name of the port, and requested quality of service.
pub(crate) type Opened = (&'static str, String, Quality);

pub(crate) struct Own {
    local: Local,
    opened: Mutex<Vec<Opened>>,
    /// Whether it says that it reaches other processes.
    far: bool,
    listed: AtomicUsize,
}

impl Own {
    pub(crate) fn new() -> Arc<Self> {
        Self::reaching(false)
    }

    /// One that says that it reaches other processes.
    pub(crate) fn far() -> Arc<Self> {
        Self::reaching(true)
    }

    fn reaching(far: bool) -> Arc<Self> {
        let (local, opened, listed) = (Local::new(), Mutex::default(), AtomicUsize::new(0));
        Arc::new(Self { local, opened, far, listed })
    }

    /// How often everything was listed.
    pub(crate) fn listed(&self) -> usize {
        self.listed.load(Ordering::Relaxed)
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
        Capabilities { cross_process: self.far, ..self.local.capabilities() }
    }

    fn services(&self) -> Option<&dyn Services> {
        self.local.services()
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }
}

impl Discovery for Own {
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        self.listed.fetch_add(1, Ordering::Relaxed);
        self.local.discover()
    }

    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        self.local.ends_at(at)
    }
}
