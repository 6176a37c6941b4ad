//! Ports: how they are opened.

use std::sync::Arc;

use crate::dds::rustdds::RTPSEntity;
use genom_kit::intake::Keeping;
use genom_kit::outlet::Outlet;
use genom_middleware::{OpenError, Policy, PortSpec, Publisher, Subscription};

use crate::dds::core::{Core, samples_of};
use crate::dds::graph::{Made, Wanted};
use crate::dds::meetings;
use crate::dds::sender::Line;
use crate::dds::wire;
use crate::error::BACKEND;
use crate::inbox::Inbox;
use crate::port::{InPort, depth_of, room_for};
use crate::ros::failed;

impl Core {
    /// Opens an out port.
    pub(crate) fn publisher(
        self: &Arc<Self>,
        port: &PortSpec<'_>,
        wanted: Wanted,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let core = self;
        let claim = core.graph.claim(at, wanted, core.announcer())?;
        let Wanted { topic, dds_type, .. } = claim.wanted();
        let qos = core.options.qos.offered(quality);
        let of_writer = wire::qos(qos.reliable, qos.transient_local, samples_of(ty));
        let writer = core.dds.writer(topic, dds_type, &of_writer);
        let writer = writer.map_err(|why| failed(at, why))?;
        if !qos.transient_local {
            meetings::prime(&writer);
        }
        let guid = writer.guid();
        let outlet = Arc::new(Outlet::new(ty, depth_of(ty, qos.depth), room_for(ty)));
        let feeds = Arc::clone(&core.feeds);
        let line = core.orders().add(Line::new(writer, topic.clone(), &outlet, feeds));
        let (writers, readers) = (vec![guid.to_bytes()], Vec::new());
        claim.made(Made { writers, readers, offers: Some(of_writer) });
        let core = Arc::clone(core);
        Ok(self.orders().out_port(outlet, line, move |line| {
            core.orders().remove(line);
            core.matches.forget(&guid);
            // Announces it to others until the last sample was sent.
            drop(claim);
        }))
    }

    /// Opens an in port.
    pub(crate) fn subscription(
        self: &Arc<Self>,
        port: &PortSpec<'_>,
        policy: Policy,
        wanted: Wanted,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let core = self;
        let keeping = Keeping::of(policy, BACKEND, ty)?;
        let claim = core.graph.claim(at, wanted, core.announcer())?;
        let feed = core.feed(claim.wanted(), ty, quality).map_err(|why| failed(at, why))?;
        let inbox = Arc::new(Inbox::new(keeping));
        feed.feed.add(&inbox);
        core.orders().offer(Arc::clone(&feed.feed));
        feed.guid(|guid| {
            let (writers, readers) = (Vec::new(), vec![guid.to_bytes()]);
            claim.made(Made { writers, readers, offers: None });
        });
        let orders = core.orders().clone();
        let complain = Box::new(move || orders.complain());
        // Dropped in order.
        let held = (feed, claim, Arc::clone(core));
        Ok(Box::new(InPort::new(ty, inbox, complain, Box::new(held))))
    }
}
