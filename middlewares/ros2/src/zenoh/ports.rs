//! Ports: how they are opened.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use genom_kit::intake::Keeping;
use genom_kit::out_port::OutPort;
use genom_kit::outlet::Outlet;
use genom_middleware::{OpenError, Policy, PortSpec, Publisher, Subscription};
use genom_types::{DataType, Kind as TypeKind};
use zenoh::Wait;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::{CongestionControl, Reliability};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use super::attachment::Attachment;
use super::core::{Core, Shown};
use super::graph::Registered;
use super::keys::{self, Kind};
use super::quality::Quality;
use super::readers::{Arrivals, Reader};
use super::sending::{Line, Numbered};
use super::told::Told;
use crate::error::BACKEND;
use crate::inbox::Inbox;
use crate::port::{InPort, depth_of, room_for};
use crate::rmw::{EndError, Wanted};
use crate::ros::failed;

/// How often a reliable transient local writer tells the number of its last sample, if there was
/// one: as `rmw_zenoh_cpp` does.
const HEARTBEAT: Duration = Duration::from_millis(500);

impl Told {
    pub(crate) fn of(wanted: &Wanted) -> Self {
        let Wanted { kind, address, digest, types, .. } = wanted.clone();
        Self { kind, address, digest, types }
    }
}

impl Core {
    /// Opens an out port.
    pub(crate) fn publisher(
        self: &Arc<Self>,
        port: &PortSpec<'_>,
        wanted: Wanted,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let registered = self.graph.register(at, wanted.clone())?;
        let qos = self.qos.offered(quality);
        let depth = depth_of(ty, qos.depth);
        let of_writer = Quality {
            reliable: qos.reliable,
            transient_local: qos.transient_local,
            depth: qos.depth.max(1),
        };
        let outlet = Arc::new(Outlet::new(ty, depth, room_for(ty)));
        let ends = self.writer(&wanted, of_writer, &outlet).map_err(|why| failed(at, why))?;
        let (line, shown, told) = ends;
        for reader in self.readers.of(&wanted.of.name) {
            reader.follow(self.session(), &self.graph);
        }
        // What announces it to others is dropped after the last sample was sent.
        let (core, shown) = (Arc::clone(self), (shown, told, registered));
        Ok(Box::new(OutPort::new(outlet, self.orders(), line, move |line| {
            core.orders().remove(line, |_, line| {
                drop(line);
                drop(shown);
            });
        })))
    }

    fn writer(
        &self,
        wanted: &Wanted,
        quality: Quality,
        outlet: &Arc<Outlet>,
    ) -> Result<(usize, Shown, LivelinessToken), EndError> {
        let key = keys::of(self.domain, &wanted.of)?;
        let draft = self.draft(&wanted.node, Kind::Publisher, &wanted.of, quality)?;
        let told = self.tell(&draft.id(), &Told::of(wanted))?;
        let publisher = self.declare(key, quality, true)?;
        // Its token is declared last, so that a reader that sees it can already ask for the last
        // value.
        let shown = self.show(&draft)?;
        let last = Attachment { number: 0, gid: draft.gid };
        let publisher = Numbered { publisher, last };
        let outlet = Arc::clone(outlet);
        Ok((self.orders().add(Line { publisher, outlet }), shown, told))
    }

    /// A publisher that keeps its last samples for those who ask: as many as a transient local one
    /// has to keep, otherwise the last one if `last` is true.
    pub(crate) fn declare(
        &self,
        key: OwnedKeyExpr,
        quality: Quality,
        last: bool,
    ) -> zenoh::Result<AdvancedPublisher<'static>> {
        let reliable = quality.reliable;
        let publisher = self
            .session()
            .declare_publisher(key)
            // A reader that cannot keep up blocks the sending thread, not the writers: their oldest
            // samples are dropped, and the last one arrives.
            .congestion_control(match reliable {
                true => CongestionControl::Block,
                false => CongestionControl::Drop,
            })
            .reliability(if reliable { Reliability::Reliable } else { Reliability::BestEffort });
        if quality.transient_local {
            let publisher = publisher
                .cache(CacheConfig::default().max_samples(quality.depth))
                .publisher_detection();
            let detects = MissDetectionConfig::default().sporadic_heartbeat(HEARTBEAT);
            return if reliable {
                publisher.sample_miss_detection(detects).wait()
            } else {
                publisher.wait()
            };
        }
        if last {
            let cache = CacheConfig::default().max_samples(1);
            return publisher.cache(cache).publisher_detection().wait();
        }
        publisher.advanced().wait()
    }

    /// Opens an in port.
    pub(crate) fn subscription(
        self: &Arc<Self>,
        port: &PortSpec<'_>,
        policy: Policy,
        wanted: Wanted,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address: at, ty, ref quality, .. } = *port;
        let keeping = Keeping::of(policy, BACKEND, ty)?;
        let registered = self.graph.register(at, wanted.clone())?;
        let qos = self.qos.offered(quality);
        let of_reader = Quality {
            reliable: qos.reliable,
            transient_local: qos.transient_local,
            depth: qos.depth.max(1),
        };
        let inbox = Arc::new(Inbox::new(keeping));
        let read = || -> Result<_, EndError> {
            let key = keys::of(self.domain, &wanted.of)?;
            let mut draft = self.draft(&wanted.node, Kind::Subscription, &wanted.of, of_reader)?;
            let (session, domain) = (self.session(), self.domain);
            // What is kept for late readers is on the other key in any case.
            let buffers = may_have_buffers(ty) && !of_reader.transient_local;
            if buffers {
                draft = draft.with_buffers(domain);
            }
            let arrivals = Arrivals::new(&wanted.of.name, &inbox, &self.refusals);
            let reader = Reader::open(session, domain, &wanted, (key, buffers), arrivals)?;
            let told = self.tell(&draft.id(), &Told::of(&wanted))?;
            Ok((self.show(&draft)?, told, reader))
        };
        let (shown, told, reader) = read().map_err(|why| failed(at, why))?;
        // Writers that appear from now on are followed then.
        self.readers.add(&reader);
        reader.follow(self.session(), &self.graph);
        // Dropped in order.
        let held: (_, _, _, Registered, _) = (reader, shown, told, registered, Arc::clone(self));
        Ok(Box::new(InPort::new(ty, inbox, Box::new(|| {}), Box::new(held))))
    }
}

/// Whether a message of a ROS type like this one may have a `uint8[]` or `char[]`. Bounds are not
/// looked at, as a type of ROS that it takes the name of may have none.
fn may_have_buffers(ty: &DataType) -> bool {
    let table = ty.table();
    let (mut left, mut seen) = (vec![ty.id()], HashSet::new());
    while let Some(id) = left.pop() {
        let kind = table.kind(id);
        if let TypeKind::Sequence { element, .. } = kind
            && matches!(table.resolved(*element), TypeKind::Octet | TypeKind::Char)
        {
            return true;
        }
        if seen.insert(id) {
            left.extend(kind.parts());
        }
    }
    false
}
