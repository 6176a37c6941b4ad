//! The middleware as the daemon sees it.

use std::borrow::Cow;
use std::sync::Arc;

use genom_middleware::{
    Address, Backend, Capabilities, Client, Diagnosis, DiscoverError, Discovery, Endpoint,
    EndpointKind, LogEntry, Middleware, NoForeignName, Obstacle, OpenError, Policy, PortSpec,
    Ports, Publisher, Refused, Served, ServiceHandler, ServiceType, Services, Subscription,
};

use crate::dds::Dds;
use crate::diagnostics::Diagnostics;
use crate::domain::Domain;
use crate::error::{BACKEND, ParticipantError};
use crate::names;
use crate::nodes::{Nodes, OfNode};
use crate::options::{Networks, Options, Rmw as Carrier};
use crate::rmw::Rmw;
use crate::ros::Ros;
use crate::rosout::Rosout;
use crate::services::ServiceEnds;
use crate::zenoh::Zenoh;

/// One participant of a domain, with one ROS node per component instance.
#[derive(Clone)]
pub struct Ros2 {
    /// Dropped before what they write with.
    rosout: Arc<Rosout>,
    diagnostics: Arc<Diagnostics>,
    ros: Arc<Ros>,
    services: Arc<ServiceEnds>,
    nodes: Arc<Nodes>,
    meeting: Vec<(Cow<'static, str>, String)>,
}

impl Ros2 {
    /// Joins a domain.
    ///
    /// # Errors
    /// An option is wrong, or the library below fails.
    pub fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        options.check()?;
        let rmw: Arc<dyn Rmw> = match options.rmw() {
            Carrier::Dds => Dds::open(options)?,
            Carrier::Zenoh => Zenoh::open(options)?,
        };
        let ros = Ros::new(rmw, options);
        let nodes = Arc::<Nodes>::default();
        let services = ServiceEnds::new(Arc::clone(&ros), Arc::clone(&nodes));
        let meeting = meeting(options)?;
        let (rosout, diagnostics) = (Arc::default(), Arc::default());
        Ok(Arc::new(Self { rosout, diagnostics, ros, services, nodes, meeting }))
    }

    /// Blocks the out port that was opened first from sending until the result is dropped, so that
    /// tests can see how a stalled network affects real-time callers.
    #[doc(hidden)]
    #[must_use]
    pub fn stall(&self) -> impl Send + use<> {
        self.ros.rmw.stall()
    }
}

/// What others must have in common with this daemon to see it.
fn meeting(options: &Options) -> Result<Vec<(Cow<'static, str>, String)>, ParticipantError> {
    let Domain { number, networks } = Domain::of(options)?;
    let rmw = match options.rmw() {
        Carrier::Dds => "dds",
        Carrier::Zenoh => "zenoh",
    };
    let networks = match networks {
        Networks::Loopback => "loopback".to_owned(),
        Networks::All => "all networks".to_owned(),
        Networks::Only(addresses) => {
            addresses.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
        }
    };
    let all = [("domain", number.to_string()), ("rmw", rmw.to_owned()), ("networks", networks)];
    Ok(all.map(|(name, value)| (Cow::from(name), value)).to_vec())
}

impl Backend for Ros2 {
    const NAME: &'static str = BACKEND;
    // The encodings have not changed since ROS 2 Iron.
    const VERSION: &'static str = "ros2-client 0.12, ROS 2 Iron to Kilted";
    const GATEWAY: bool = true;
    type Options = Options;
    type Error = ParticipantError;

    fn check(options: &Options) -> Result<(), ParticipantError> {
        options.check()?;
        if options.rmw() == Carrier::Zenoh {
            crate::zenoh::check(options)?;
        }
        Ok(())
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
        Capabilities::NETWORK
    }

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        self.meeting.clone()
    }

    fn services(&self) -> Option<&dyn Services> {
        Some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        Some(self)
    }

    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        match names::is_type(ours) {
            true => self.ros.masquerades.add(ours, foreign),
            false => self.ros.names.give(ours, foreign),
        }
    }

    fn unmask(&self, ours: &str) {
        match names::is_type(ours) {
            true => self.ros.masquerades.remove(ours),
            false => self.ros.names.take_back(ours),
        }
    }

    fn simulated_time(&self) {
        self.ros.simulate();
    }

    fn takes_reports(&self) -> bool {
        true
    }

    fn log(&self, entry: &LogEntry) {
        self.rosout.put(&self.ros, entry);
    }

    fn diagnose(&self, tasks: &[Diagnosis]) {
        self.diagnostics.put(&self.ros, tasks);
    }

    fn trouble(&self) -> Vec<Obstacle> {
        self.ros.rmw.trouble()
    }

    fn refused(&self) -> Vec<Refused> {
        self.ros.rmw.refused()
    }
}

impl Ports for Ros2 {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let (wanted, used) = self.ros.port(EndpointKind::Publisher, port.address, port.ty)?;
        let _part = self.nodes.port(&self.ros, port.address, used);
        let port = self.ros.rmw.publisher(port, wanted)?;
        Ok(Box::new(OfNode { port, _part }))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let (wanted, _) = self.ros.port(EndpointKind::Subscription, port.address, port.ty)?;
        self.ros.rmw.subscription(port, policy, wanted)
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
        Ok(self.ros.rmw.list())
    }

    fn spelled(&self, at: &Address) -> String {
        self.ros.names.full(at)
    }

    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        self.ros.rmw.obstacles(at, &self.ros.names.path(at))
    }
}
