//! Ports: how they are opened, and their ends as the runtime sees them.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_kit::intake::{Intake, Keeping};
use genom_kit::outlet::Outlet;
use genom_middleware::{
    EndpointKind, OpenError, Policy, PortSpec, Ports, PublishError, Publisher, ReadError, Reading,
    Subscription,
};
use genom_types::{DataType, Record};
use rustdds::{GUID, RTPSEntity};

use crate::backend::Ros2;
use crate::core::{Core, samples_of};
use crate::error::BACKEND;
use crate::feeds::FeedHandle;
use crate::graph::{Claim, Made, Wanted};
use crate::inbox::Inbox;
use crate::meetings;
use crate::quality;
use crate::sender::Line;
use crate::wire;

/// Limit in bytes for the samples of an out port that wait to be sent.
const WAITING: usize = 4 << 20;

/// Initial buffer size in bytes for a message of the type.
fn room_for(ty: &DataType) -> usize {
    if ty.is_fixed_size() { ty.size() + ty.size() / 8 + 64 } else { 256 }
}

/// Number of samples that may wait to be sent: fewer if they are large, since their buffers are
/// preallocated.
fn depth_of(ty: &DataType, wanted: usize) -> usize {
    wanted.min((WAITING / room_for(ty)).max(1))
}

impl Ports for Ros2 {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let core = &self.core;
        let wanted = core.port(EndpointKind::Publisher, at, ty)?;
        let claim = core.graph.claim(at, wanted, core.announcer())?;
        let Wanted { topic, dds_type, .. } = claim.wanted();
        let qos = quality::offered(quality, &core.options.qos);
        let of_writer = wire::qos(qos.reliable, qos.transient_local, samples_of(ty));
        let writer = core.dds.writer(topic, dds_type, &of_writer);
        let writer = writer.map_err(|why| core.failed(at, why))?;
        if !qos.transient_local {
            meetings::prime(&writer);
        }
        let guid = writer.guid();
        let outlet = Arc::new(Outlet::new(ty, depth_of(ty, qos.depth), room_for(ty)));
        let feeds = Arc::clone(&core.feeds);
        let line = core.orders().add(Line::new(writer, topic.clone(), &outlet, feeds));
        let (writers, readers) = (vec![guid.to_bytes()], Vec::new());
        claim.made(Made { writers, readers, offers: Some(of_writer) });
        Ok(Box::new(Ros2Publisher {
            outlet,
            line,
            writer: guid,
            claim: Some(claim),
            core: Arc::clone(core),
        }))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let core = &self.core;
        let keeping = Keeping::of(policy, BACKEND, ty)?;
        let wanted = core.port(EndpointKind::Subscription, at, ty)?;
        let claim = core.graph.claim(at, wanted, core.announcer())?;
        let feed = core.feed(claim.wanted(), ty, quality).map_err(|why| core.failed(at, why))?;
        let inbox = Arc::new(Inbox::new(keeping));
        feed.feed.add(&inbox);
        core.orders().offer(Arc::clone(&feed.feed));
        feed.guid(|guid| {
            let (writers, readers) = (Vec::new(), vec![guid.to_bytes()]);
            claim.made(Made { writers, readers, offers: None });
        });
        Ok(Box::new(Ros2Subscription {
            intake: Intake::new(ty),
            inbox,
            _feed: feed,
            _claim: claim,
            core: Arc::clone(core),
        }))
    }
}

/// An out port.
pub(crate) struct Ros2Publisher {
    outlet: Arc<Outlet>,
    /// Its number in the sending thread.
    line: usize,
    writer: GUID,
    /// Announces it to others; dropped after the last sample was sent.
    claim: Option<Claim>,
    core: Arc<Core>,
}

impl Publisher for Ros2Publisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.outlet.put(value)?;
        self.core.orders().mark(self.line);
        Ok(())
    }

    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        let put = self.outlet.put_message(message);
        self.core.orders().mark(self.line);
        Some(put)
    }

    fn dropped(&self) -> u64 {
        self.outlet.dropped()
    }
}

impl Drop for Ros2Publisher {
    fn drop(&mut self) {
        self.core.orders().remove(self.line);
        self.core.matches.forget(&self.writer);
        self.claim = None;
    }
}

/// An in port. Fields are dropped in order.
pub(crate) struct Ros2Subscription {
    intake: Intake,
    inbox: Arc<Inbox>,
    _feed: Arc<FeedHandle>,
    _claim: Claim,
    core: Arc<Core>,
}

impl Ros2Subscription {
    fn counted(&self, reading: Result<Reading, ReadError>) -> Result<Reading, ReadError> {
        if reading == Err(ReadError::Serialization) {
            self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
            self.core.orders().complain();
        }
        reading
    }
}

impl Subscription for Ros2Subscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let mailbox = &self.inbox.mailbox;
        let reading = self.intake.read(into, |decode| mailbox.take(|message| decode(message)));
        self.counted(reading)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        let mailbox = &self.inbox.mailbox;
        let reading = self.intake.read_message(into, |see| mailbox.take(|message| see(message)));
        Some(self.counted(reading))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.told.0.set(told).is_ok()
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost()
    }
}
