//! ROS 2 over zenoh, as `rmw_zenoh_cpp` does it: one session for the daemon.
//!
//! A topic is the key `<domain>/<name>/<type>/<hash>`, a service a queryable of that key. Each node
//! and end has a liveliness token, which is all that others know of it. Samples, requests and
//! replies have an attachment: number, time, gid.

mod attachment;
mod core;
mod graph;
mod keys;
mod numbers;
mod ports;
mod quality;
mod readers;
mod refusals;
mod router;
mod sending;
mod services;
mod session;
mod told;
mod topics;
mod trouble;

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use genom_middleware::{
    Address, Endpoint, EndpointKind, Obstacle, OpenError, Policy, PortSpec, Publisher, Refused,
    Subscription,
};
use genom_rosidl::TypeName;
use zenoh::liveliness::LivelinessToken;

use crate::domain::Domain;
use crate::error::ParticipantError;
use crate::options::{Options, OptionsError};
use crate::rmw::{
    Claim, ClientEnd, EndError, Entities, Named, OnMessage, OnRequest, Rmw, ServerEnd, Service,
    TopicWriter, Wanted,
};
use crate::ros::failed;

use graph::Registered;
use keys::Kind;
use session::Settings;
use told::Told;

/// ROS 2 over zenoh.
pub(crate) struct Zenoh(Arc<core::Core>);

impl Zenoh {
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        Ok(Arc::new(Self(core::Core::open(options)?)))
    }
}

/// Checks that the session can be configured.
pub(crate) fn check(options: &Options) -> Result<(), OptionsError> {
    let domain = Domain::of(options)?;
    Settings::of(options, &domain.networks).map(|_| ())
}

/// A service of ours. Fields are dropped in order.
struct Claimed {
    _told: LivelinessToken,
    _registered: Registered,
    name: String,
    core: Arc<core::Core>,
}

impl Claim for Claimed {
    // Its tokens tell what it has.
    fn made(&self, _: Entities) {}
}

impl Drop for Claimed {
    fn drop(&mut self) {
        self.core.unclaim(&self.name);
    }
}

impl Rmw for Zenoh {
    fn publisher(
        &self,
        port: &PortSpec<'_>,
        wanted: Wanted,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        self.0.publisher(port, wanted)
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
        wanted: Wanted,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        self.0.subscription(port, policy, wanted)
    }

    fn claim(&self, at: &Address, wanted: &Wanted) -> Result<Box<dyn Claim>, OpenError> {
        let core = &self.0;
        let registered = core.graph.register(at, wanted.clone())?;
        let name = wanted.of.name.clone();
        let id = (core.zid.clone(), core.claim(&name));
        let told = core.tell(&id, &Told::of(wanted)).map_err(|why| failed(at, why))?;
        Ok(Box::new(Claimed { _told: told, _registered: registered, name, core: Arc::clone(core) }))
    }

    fn belong(&self, _: &str, _: Entities) -> Box<dyn Send + Sync> {
        Box::new(())
    }

    fn server(
        &self,
        node: &str,
        of: &Named,
        on_request: OnRequest,
    ) -> Result<Box<dyn ServerEnd>, EndError> {
        Ok(Box::new(services::Server::open(&self.0, node, of, on_request)?))
    }

    fn caller(&self, node: &str, of: &Named) -> Result<Box<dyn ClientEnd>, EndError> {
        Ok(Box::new(services::Caller::open(&self.0, node, of)?))
    }

    fn writer(
        &self,
        node: &str,
        of: &Named,
        latched: bool,
    ) -> Result<Arc<dyn TopicWriter>, EndError> {
        Ok(Arc::new(topics::Writing::open(&self.0, node, of, latched)?))
    }

    fn reader(
        &self,
        node: &str,
        of: &Named,
        on_message: OnMessage,
    ) -> Result<Box<dyn Send + Sync>, EndError> {
        Ok(Box::new(topics::Reading::open(&self.0, node, of, on_message)?))
    }

    fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        self.0.graph.service(wanted, end)
    }

    fn nodes(&self) -> HashSet<String> {
        self.0.node_names()
    }

    // Tokens go out at once.
    fn settle(&self) {}

    fn mark(&self) -> [u8; 8] {
        let id = self.0.session().zid().to_le_bytes();
        id.first_chunk().copied().unwrap_or_default()
    }

    fn list(&self) -> Vec<Endpoint> {
        self.0.graph.list()
    }

    fn obstacles(&self, at: &Address, topic: &str) -> Vec<Obstacle> {
        let others = self.0.graph.others(topic);
        let mut all = Vec::new();
        for own in self.0.graph.ours(topic) {
            let opposite = match own.kind {
                EndpointKind::Publisher => (Kind::Subscription, "reader"),
                EndpointKind::Subscription => (Kind::Publisher, "writer"),
                EndpointKind::Service => continue,
            };
            let Some(hash) = &own.of.hash else { continue };
            let ty = own.of.ty.to_dds("");
            let differs =
                |end: &&keys::End| end.kind == opposite.0 && end.ty == ty && end.hash != *hash;
            all.extend(others.iter().filter(differs).map(|end| Obstacle {
                what: format!(
                    "a {} of {at} on ros2 means another structure by {}: {}, and the port {hash}",
                    opposite.1,
                    TypeName::from_dds(&end.ty),
                    end.hash,
                ),
                fix: "make the two types equal: `genomctl ros2-package` writes that of the port"
                    .to_owned(),
            }));
        }
        all.dedup();
        all
    }

    fn trouble(&self) -> Vec<Obstacle> {
        trouble::trouble(&self.0)
    }

    fn refused(&self) -> Vec<Refused> {
        self.0.refusals.list()
    }

    fn stall(&self) -> Box<dyn Send> {
        Box::new(self.0.orders().stall())
    }
}
