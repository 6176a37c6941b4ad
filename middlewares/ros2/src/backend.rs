//! The middleware as the daemon sees it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use genom_middleware::describe::type_of_port;
use genom_middleware::mailbox::{Full, Mailbox};
use genom_middleware::{
    Address, Capabilities, Client, DiscoverError, Endpoint, EndpointKind, Middleware, Obstacle,
    OpenError, Policy, Publisher, Quality, Refused, Served, ServiceHandler, ServiceType,
    Subscription,
};
use genom_types::{DataType, Record};
use rustdds::bytes::Bytes;
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantStatusEvent as Event,
    EndpointDescription, LostReason, QosPolicies, RTPSEntity, TopicKind,
};

use crate::farewell::Farewell;
use crate::feed::{Feed, FeedHandle, Feeds, Inbox};
use crate::graph::{Found, Graph, Made, Wanted};
use crate::guard::Tally;
use crate::hook;
use crate::info::{self, Ends};
use crate::masquerades::Masquerades;
use crate::meetings;
use crate::names;
use crate::options::{Options, OptionsError};
use crate::ports::{Ros2Publisher, Ros2Subscription};
use crate::post::Matches;
use crate::process::Process;
use crate::quality::{self, Ours, Wish};
use crate::receiver::{Inlet, Sample, Sink};
use crate::reunions::Reunions;
use crate::sender::{Announce, Orders, Outlet, Worker};
use crate::services::Services;
use crate::wire::{self, Payload, Reader, Writer};

/// Samples the DDS library keeps for one topic may take that much memory in all.
const MEMORY: usize = 32 << 20;

/// So may those of an out port that wait to be sent.
const WAITING: usize = 4 << 20;

/// The middleware could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParticipantError {
    /// An option is wrong.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// DDS did not open.
    #[error("DDS does not open domain {domain}: {why}")]
    Dds {
        /// The domain.
        domain: u16,
        /// The library's own words.
        why: String,
    },
    /// No thread could be had.
    #[error("no thread for ROS 2: {0}")]
    Thread(#[from] std::io::Error),
}

/// One DDS participant, with one ROS node for each component instance.
#[derive(Clone)]
pub struct Ros2 {
    core: Arc<Core>,
}

/// What ports keep alive. Fields are dropped in order: threads first.
pub(crate) struct Core {
    feeds: Arc<Feeds>,
    worker: Worker,
    pub(crate) inlet: Arc<Inlet>,
    pub(crate) matches: Arc<Matches>,
    pub(crate) services: Services,
    pub(crate) graph: Arc<Graph>,
    pub(crate) dds: Arc<Dds>,
    _farewell: Farewell,
    /// What was kept from DDS.
    tally: Arc<Tally>,
    pub(crate) options: Options,
    pub(crate) masquerades: Masquerades,
}

/// Makes writers and readers.
pub(crate) struct Dds {
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    participant: DomainParticipant,
    /// Topics that were ever written or read here, with type and quality.
    opened: Mutex<HashMap<(String, Direction), (String, QosPolicies)>>,
}

/// Which end of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Direction {
    Writes,
    Reads,
}

/// What this daemon tells of itself.
struct Told {
    ends: Writer,
    nodes: Writer,
    graph: Arc<Graph>,
    feeds: Arc<Feeds>,
    namespace: String,
    participant: info::Gid,
    process: Process,
}

impl Announce for Told {
    fn tell(&self) -> bool {
        let (ends, nodes) = self.graph.ours(&self.namespace);
        let ends = info::encode(&Ends { process: self.process.clone(), ends });
        let nodes = info::encode(&Graph::nodes(self.participant, nodes));
        [(&self.ends, ends), (&self.nodes, nodes)].into_iter().all(|(writer, payload)| {
            // What cannot be encoded will not be by trying again.
            let Some(payload) = payload else { return true };
            writer.write(Payload(Bytes::from(payload)), None).is_ok()
        })
    }

    fn settle(&self, longest: Duration) {
        // Those that are gone without a word are not waited for any longer.
        let _ = self.ends.wait_for_acknowledgments(longest);
    }

    fn complain(&self) {
        self.feeds.complain();
    }
}

/// Takes what other daemons tell.
struct Hear {
    graph: Arc<Graph>,
    feeds: Arc<Feeds>,
    ourselves: rustdds::GUID,
}

impl Sink for Hear {
    fn arrive(&mut self, sample: Sample<'_>) {
        if sample.writer.prefix == self.ourselves.prefix {
            return;
        }
        match info::decode::<Ends>(sample.message) {
            Some(ends) => {
                self.graph.told(sample.writer, ends);
                self.feeds.settle();
            }
            None => tracing::warn!("a participant tells what cannot be read; it is left out"),
        }
    }
}

impl Dds {
    fn open(options: &Options) -> Result<Self, String> {
        let mut builder = DomainParticipantBuilder::new(options.domain);
        if let Some(addresses) = options.addresses() {
            builder = builder.with_only_networks(addresses);
        }
        let participant = builder.build().map_err(|error| error.to_string())?;
        let qos = QosPolicies::qos_none();
        let publisher = participant.create_publisher(&qos).map_err(|error| error.to_string())?;
        let subscriber = participant.create_subscriber(&qos).map_err(|error| error.to_string())?;
        Ok(Self { publisher, subscriber, participant, opened: Mutex::default() })
    }

    fn topic(&self, name: &str, ty: &str, qos: &QosPolicies) -> Result<rustdds::Topic, String> {
        self.participant
            .create_topic(name.to_owned(), ty.to_owned(), qos, TopicKind::NoKey)
            .map_err(|error| error.to_string())
    }

    fn note(&self, topic: &str, direction: Direction, ty: &str, qos: &QosPolicies) {
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.insert((topic.to_owned(), direction), (ty.to_owned(), qos.clone()));
    }

    /// Type and quality of what was last opened on a topic.
    pub(crate) fn opened(
        &self,
        topic: &str,
        direction: Direction,
    ) -> Option<(String, QosPolicies)> {
        let opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened.get(&(topic.to_owned(), direction)).cloned()
    }

    pub(crate) fn writer(
        &self,
        topic: &str,
        ty: &str,
        qos: &QosPolicies,
    ) -> Result<Writer, String> {
        self.note(topic, Direction::Writes, ty, qos);
        let topic = self.topic(topic, ty, qos)?;
        let writer = self.publisher.create_datawriter_no_key(&topic, Some(qos.clone()));
        writer.map_err(|error| error.to_string())
    }

    pub(crate) fn reader(
        &self,
        topic: &str,
        ty: &str,
        qos: &QosPolicies,
    ) -> Result<Reader, String> {
        self.note(topic, Direction::Reads, ty, qos);
        self.moment(topic, ty, qos)
    }

    /// A reader that is not one of the topic's.
    pub(crate) fn moment(
        &self,
        topic: &str,
        ty: &str,
        qos: &QosPolicies,
    ) -> Result<Reader, String> {
        let topic = self.topic(topic, ty, qos)?;
        let reader = self.subscriber.create_simple_datareader_no_key(&topic, Some(qos.clone()));
        reader.map_err(|error| error.to_string())
    }
}

impl Core {
    pub(crate) fn orders(&self) -> &Orders {
        &self.worker.orders
    }

    /// Has others told of a change of ours.
    pub(crate) fn announcer(&self) -> Box<dyn Fn() + Send + Sync> {
        let orders = self.orders().clone();
        Box::new(move || orders.announce())
    }

    /// The name of an address in messages and lists, and without its slash in ROS.
    pub(crate) fn path(&self, at: &Address) -> String {
        names::path(&self.options.namespace, at)
    }

    /// The address with the namespace in front.
    pub(crate) fn full(&self, at: &Address) -> String {
        match self.options.namespace.trim_matches('/') {
            _ if at.instance.is_empty() => at.name.clone(),
            "" => at.to_string(),
            namespace => format!("{namespace}/{at}"),
        }
    }

    fn port(&self, kind: EndpointKind, at: &Address, ty: &DataType) -> Result<Wanted, OpenError> {
        let message = self.masquerades.message(ty).map_err(|why| self.failed(at, why))?;
        Ok(Wanted {
            kind,
            address: self.full(at),
            types: type_of_port(ty),
            digest: ty.digest().to_owned(),
            topic: format!("rt/{}", self.path(at)),
            dds_type: message.to_dds(""),
            hash: self.masquerades.hash(ty),
            node: match kind {
                // The address is that of the writer; who reads is not known here.
                EndpointKind::Subscription => format!("genomd_{}", std::process::id()),
                _ => names::token(&at.instance),
            },
        })
    }

    pub(crate) fn failed(&self, at: &Address, why: String) -> OpenError {
        OpenError::Failed { backend: "ros2".to_owned(), address: at.clone(), why }
    }

    /// The reader of a topic, made unless there is one.
    fn feed(
        &self,
        wanted: &Wanted,
        ty: &DataType,
        quality: &Quality,
    ) -> Result<Arc<FeedHandle>, String> {
        let wish = Wish::new(quality, &self.options.qos);
        self.feeds.get(&wanted.topic, wish, || {
            let ourselves = self.dds.participant.guid();
            let feed = Feed::new(wanted, Arc::clone(&self.graph), ourselves);
            let by = (&self.inlet, self.orders(), &self.dds);
            FeedHandle::open(feed, (wish, samples_of(ty)), by)
        })
    }

    /// What keeps an end of others on a topic from meeting ours, or all of them.
    fn obstacles(&self, at: &Address, topic: &str) -> Vec<Obstacle> {
        obstacles(&self.graph, &self.feeds, at, topic)
    }
}

fn obstacles(graph: &Graph, feeds: &Feeds, at: &Address, topic: &str) -> Vec<Obstacle> {
    let mut all = Vec::new();
    if let Some((ours, offers)) = graph.writer(topic) {
        for (_, reader) in graph.others(topic, false) {
            all.extend(quality::other_structure(at, Ours::Writer, ours.hash.as_deref(), &reader));
            all.extend(quality::obstacle(at, Ours::Writer, &offers, &reader.qos));
        }
    }
    for handle in feeds.of(topic) {
        let (asks, hash) = (handle.qos(), handle.feed.hash.as_deref());
        let writers = graph.others(topic, true);
        for (_, writer) in &writers {
            all.extend(quality::other_structure(at, Ours::Reader, hash, writer));
            all.extend(quality::obstacle(at, Ours::Reader, &writer.qos, &asks));
        }
        all.extend(quality::mixed(at, &asks, &writers));
    }
    all.dedup();
    all
}

/// Says what keeps an end that came from meeting ours.
fn tell_obstacles(graph: &Graph, feeds: &Feeds, topic: &str) {
    let Some(name) = topic.strip_prefix("rt/") else { return };
    for Obstacle { what, fix } in obstacles(graph, feeds, &Address::new("", name), topic) {
        tracing::warn!("{what}: {fix}");
    }
}

/// Samples of a type that fit into [`MEMORY`].
fn samples_of(ty: &DataType) -> i32 {
    let size = if ty.is_fixed_size() { ty.size().max(1) } else { MEMORY / 64 };
    i32::try_from((MEMORY / size).clamp(4, 1024)).unwrap_or(4)
}

/// Bytes to make ready for a message of a type.
fn room_for(ty: &DataType) -> usize {
    if ty.is_fixed_size() { ty.size() + ty.size() / 8 + 64 } else { 256 }
}

/// Samples that may wait to be sent: fewer of large ones, whose buffers are made beforehand.
fn depth_of(ty: &DataType, wanted: usize) -> usize {
    wanted.min((WAITING / room_for(ty)).max(1))
}

fn found(end: EndpointDescription, writer: bool) -> (rustdds::GUID, Found) {
    (end.guid, Found::new(end, writer))
}

impl Ros2 {
    /// Keeps the sending thread from its work until the result is dropped: for tests of what
    /// real-time callers feel of a stalled network.
    #[doc(hidden)]
    #[must_use]
    pub fn stall(&self) -> impl Send + use<> {
        let (release, held) = std::sync::mpsc::channel::<()>();
        let (begun, begins) = std::sync::mpsc::channel();
        self.core.orders().submit(move || {
            let _ = begun.send(());
            let _ = held.recv();
        });
        let _ = begins.recv();
        release
    }

    /// Joins a domain.
    ///
    /// # Errors
    /// An option is wrong, or DDS does not open.
    pub fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        options.check()?;
        let failed = |why| ParticipantError::Dds { domain: options.domain, why };
        let tally = hook::guard(options.domain, options.limits);
        let dds = Arc::new(Dds::open(options).map_err(failed)?);
        let graph = Arc::new(Graph::default());
        let told_qos = wire::qos(true, true, 256);
        let writer = |(topic, ty)| dds.writer(topic, ty, &told_qos).map_err(failed);
        let feeds = Arc::new(Feeds::default());
        let told = Told {
            ends: writer(info::ENDS)?,
            nodes: writer(info::NODES)?,
            graph: Arc::clone(&graph),
            feeds: Arc::clone(&feeds),
            namespace: options.namespace.clone(),
            participant: dds.participant.guid().to_bytes(),
            process: Process::this(),
        };
        let matches = Arc::new(Matches::default());
        let worker = Worker::start(Box::new(told), Arc::clone(&matches))?;
        let ourselves = dds.participant.guid();
        let (known, orders) = (Arc::clone(&graph), worker.orders.clone());
        let hearing = Arc::clone(&feeds);
        let mut reunions = Reunions::new(Arc::clone(&dds));
        let news = move |event| match event {
            Event::WriterDetected { writer } if writer.guid.prefix != ourselves.prefix => {
                let (guid, found) = found(writer, true);
                let topic = found.topic.clone();
                let new = known.found(guid, found);
                hearing.follow(&topic);
                hearing.settle();
                if new {
                    tell_obstacles(&known, &hearing, &topic);
                }
            }
            Event::ReaderDetected { reader } if reader.guid.prefix != ourselves.prefix => {
                let (guid, found) = found(reader, false);
                let topic = found.topic.clone();
                if known.found(guid, found) {
                    tell_obstacles(&known, &hearing, &topic);
                }
            }
            Event::WriterLost { guid, .. } => known.lost(&guid),
            Event::ReaderLost { guid, .. } => {
                known.lost(&guid);
                orders.part(move |reader| *reader == guid);
            }
            Event::ParticipantLost { id, reason } => {
                let silent = matches!(reason, LostReason::Timeout { .. });
                let ends = known.lost_all(|guid| guid.prefix == id, silent);
                reunions.lost(id, ends, silent);
                orders.part(move |reader| reader.prefix == id);
            }
            Event::ParticipantDiscovered { dpd } => reunions.found(dpd.guid.prefix),
            Event::RemoteReaderMatched { local_writer, remote_reader }
                if !reunions.matched(local_writer) =>
            {
                orders.meet(local_writer, remote_reader);
            }
            Event::RemoteWriterMatched { local_reader, .. } => _ = reunions.matched(local_reader),
            _ => {}
        };
        let inlet = Inlet::start(dds.participant.status_listener(), Box::new(news))?;
        let reader = dds.reader(info::ENDS.0, info::ENDS.1, &told_qos).map_err(failed)?;
        let hear = Hear { graph: Arc::clone(&graph), feeds: Arc::clone(&feeds), ourselves };
        inlet.add(reader, Box::new(hear));
        let core = Core {
            feeds,
            worker,
            inlet: Arc::new(inlet),
            matches,
            services: Services::default(),
            graph,
            dds,
            _farewell: Farewell {
                participant: ourselves,
                domain: options.domain,
                addresses: options.addresses(),
            },
            tally,
            options: options.clone(),
            masquerades: Masquerades::new(options),
        };
        core.announcer()();
        Ok(Arc::new(Self { core: Arc::new(core) }))
    }
}

impl Middleware for Ros2 {
    fn name(&self) -> &'static str {
        "ros2"
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

    fn publisher(&self, at: &Address, ty: &DataType) -> Result<Box<dyn Publisher>, OpenError> {
        self.publisher_of(at, ty, &Quality::default())
    }

    fn subscription(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        self.subscription_of(at, ty, policy, &Quality::default())
    }

    fn publisher_of(
        &self,
        at: &Address,
        ty: &DataType,
        quality: &Quality,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        let core = &self.core;
        ty.prepare();
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
        let outlet = Arc::new(Outlet {
            mailbox: Mailbox::new(depth_of(ty, qos.depth), room_for(ty), Full::Oldest),
            room: room_for(ty),
            waits: AtomicBool::new(false),
            refused: AtomicU64::new(0),
        });
        core.orders().add(writer, topic.clone(), Arc::clone(&outlet), Arc::clone(&core.feeds));
        let (writers, readers) = (vec![guid.to_bytes()], Vec::new());
        claim.made(Made { writers, readers, offers: Some(of_writer) });
        Ok(Box::new(Ros2Publisher {
            ty: ty.clone(),
            outlet,
            writer: guid,
            claim: Some(claim),
            core: Arc::clone(core),
        }))
    }

    fn subscription_of(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
        quality: &Quality,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let core = &self.core;
        ty.prepare();
        let wanted = core.port(EndpointKind::Subscription, at, ty)?;
        let claim = core.graph.claim(at, wanted, core.announcer())?;
        let feed = core.feed(claim.wanted(), ty, quality).map_err(|why| core.failed(at, why))?;
        let inbox = Arc::new(Inbox::new(policy));
        feed.feed.add(&inbox);
        core.orders().offer(Arc::clone(&feed.feed));
        feed.guid(|guid| {
            let (writers, readers) = (Vec::new(), vec![guid.to_bytes()]);
            claim.made(Made { writers, readers, offers: None });
        });
        Ok(Box::new(Ros2Subscription {
            scratch: Record::new(ty),
            inbox,
            read: false,
            _feed: feed,
            _claim: claim,
            core: Arc::clone(core),
        }))
    }

    fn spelled(&self, at: &Address) -> String {
        self.core.full(at)
    }

    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        self.core.obstacles(at, &format!("rt/{}", self.core.path(at)))
    }

    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        self.core.serve(at, service, handler)
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        self.core.client(at, service)
    }

    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), String> {
        self.core.masquerades.add(ours, foreign)
    }

    fn refused(&self) -> Vec<Refused> {
        let refused = self.core.tally.list().into_iter();
        refused.map(|(why, count, peer)| Refused { why: why.text(), count, peer }).collect()
    }

    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        Ok(self.core.graph.list())
    }
}
