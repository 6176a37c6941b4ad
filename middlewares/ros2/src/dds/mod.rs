//! ROS 2 over DDS: one participant for the daemon.

mod channel;
mod core;
mod farewell;
mod feed;
mod feeds;
mod graph;
mod info;
mod meetings;
mod news;
mod numbering;
mod obstacles;
mod participant;
mod patience;
mod ports;
mod post;
mod process;
mod quality;
mod receiver;
mod reunions;
mod sender;
mod told;
mod topics;
mod wire;

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use genom_middleware::{
    Address, Endpoint, Obstacle, OpenError, Policy, PortSpec, Publisher, Refused, Subscription,
};

/// RustDDS in the version that ros2-client has.
pub(crate) use ros2_client::dds::rustdds;
use rustdds::RTPSEntity as _;

use crate::error::ParticipantError;
use crate::options::Options;
use crate::rmw::{
    self, ClientEnd, EndError, Entities, Named, OnMessage, OnRequest, Rmw, ServerEnd, Service,
    TopicWriter, Wanted,
};

use channel::{Caller, Names, Server};
use graph::Made;

/// ROS 2 over DDS.
pub(crate) struct Dds(Arc<core::Core>);

impl Dds {
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        Ok(Arc::new(Self(core::Core::open(options)?)))
    }
}

impl rmw::Claim for graph::Claim {
    fn made(&self, Entities { writers, readers }: Entities) {
        graph::Claim::made(self, Made { writers, readers, offers: None });
    }
}

impl Rmw for Dds {
    fn publisher(
        &self,
        port: &PortSpec<'_>,
        wanted: Wanted,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        self.0.publisher(port, graph::Wanted::of(&wanted))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
        wanted: Wanted,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        self.0.subscription(port, policy, graph::Wanted::of(&wanted))
    }

    fn claim(&self, at: &Address, wanted: &Wanted) -> Result<Box<dyn rmw::Claim>, OpenError> {
        let wanted = graph::Wanted::of(wanted);
        Ok(Box::new(self.0.graph.claim(at, wanted, self.0.announcer())?))
    }

    fn belong(&self, node: &str, Entities { writers, readers }: Entities) -> Box<dyn Send + Sync> {
        let entities = graph::Entities { node: node.to_owned(), writers, readers };
        Box::new(self.0.graph.belong(entities, self.0.announcer()))
    }

    // Which node has an end is told by `claim` and `belong`.
    fn server(
        &self,
        _: &str,
        of: &Named,
        on_request: OnRequest,
    ) -> Result<Box<dyn ServerEnd>, EndError> {
        let (dds, maker) = (&self.0.dds, self.0.maker());
        Ok(Box::new(Server::open(dds, &maker, &Names::of(of), on_request)?))
    }

    fn caller(&self, _: &str, of: &Named) -> Result<Box<dyn ClientEnd>, EndError> {
        Ok(Box::new(Caller::open(&self.0.dds, &self.0.maker(), &Names::of(of))?))
    }

    fn writer(&self, _: &str, of: &Named, latched: bool) -> Result<Arc<dyn TopicWriter>, EndError> {
        Ok(Arc::new(topics::Writing::open(&self.0, of, latched)?))
    }

    fn reader(
        &self,
        _: &str,
        of: &Named,
        on_message: OnMessage,
    ) -> Result<Box<dyn Send + Sync>, EndError> {
        Ok(Box::new(topics::Reading::open(&self.0, of, on_message)?))
    }

    fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        self.0.graph.service(&graph::Wanted::of(wanted), end)
    }

    fn nodes(&self) -> HashSet<String> {
        self.0.graph.node_names()
    }

    fn settle(&self) {
        self.0.orders().announce_now();
    }

    fn mark(&self) -> [u8; 8] {
        let mut mark = [0; 8];
        let of = self.0.dds.participant.guid().to_bytes();
        mark.iter_mut().zip(of.iter().skip(4)).for_each(|(to, byte)| *to = *byte);
        mark
    }

    fn list(&self) -> Vec<Endpoint> {
        self.0.graph.list()
    }

    fn obstacles(&self, at: &Address, topic: &str) -> Vec<Obstacle> {
        obstacles::obstacles(&self.0.graph, &self.0.feeds, at, &format!("rt/{topic}"))
    }

    fn refused(&self) -> Vec<Refused> {
        let refused = self.0.tally.list().into_iter();
        refused.map(|(why, count, peer)| Refused { why: why.text().into(), count, peer }).collect()
    }

    fn stall(&self) -> Box<dyn Send> {
        Box::new(self.0.orders().stall())
    }
}
