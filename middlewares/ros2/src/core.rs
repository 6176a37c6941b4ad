//! What all ends share: the participant, its threads, and the graph of known ends.

use std::sync::Arc;

use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, EndpointKind, OpenError, Quality};
use genom_types::DataType;
use rustdds::RTPSEntity;
use rustdds::dds::CreateResult;

use crate::channel::Maker;
use crate::dds::Dds;
use crate::domain::Domain;
use crate::error::{BACKEND, ParticipantError};
use crate::farewell::Farewell;
use crate::feed::Feed;
use crate::feeds::{FeedHandle, Feeds};
use crate::graph::{Graph, Wanted};
use crate::guard::Tally;
use crate::hook;
use crate::info;
use crate::masquerades::Masquerades;
use crate::names;
use crate::news::news;
use crate::options::Options;
use crate::post::Matches;
use crate::process::Process;
use crate::quality::Wish;
use crate::receiver::Inlet;
use crate::reunions::Reunions;
use crate::sender::{Orders, Sending};
use crate::told::{Hear, Told};
use crate::wire;

/// Limit in bytes for the samples that the DDS library keeps for one topic.
const MEMORY: usize = 32 << 20;

/// Kept alive by ports and services. Fields are dropped in order: threads first.
pub(crate) struct Core {
    pub(crate) feeds: Arc<Feeds>,
    sender: Sending,
    pub(crate) inlet: Arc<Inlet>,
    pub(crate) matches: Arc<Matches>,
    pub(crate) graph: Arc<Graph>,
    pub(crate) dds: Arc<Dds>,
    _farewell: Farewell,
    /// Counts what the guard kept from DDS.
    pub(crate) tally: Arc<Tally>,
    pub(crate) options: Options,
    pub(crate) masquerades: Masquerades,
}

impl Core {
    /// Joins a domain.
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        options.check()?;
        let domain = Domain::of(options)?;
        let failed = |why| ParticipantError::Dds { domain: domain.number, why };
        let tally = hook::guard(domain.number, options.limits());
        let dds = Arc::new(Dds::open(&domain).map_err(failed)?);
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
        let sender = Sending::start(Box::new(told), Arc::clone(&matches))?;
        let ourselves = dds.participant.guid();
        let news = news(
            ourselves,
            Arc::clone(&graph),
            Arc::clone(&feeds),
            sender.orders().clone(),
            Reunions::new(Arc::clone(&dds)),
        );
        let inlet = Inlet::start(dds.participant.status_listener(), news)?;
        let reader = dds.reader(info::ENDS.0, info::ENDS.1, &told_qos).map_err(failed)?;
        let hear = Hear { graph: Arc::clone(&graph), feeds: Arc::clone(&feeds), ourselves };
        inlet.add(reader, Box::new(hear));
        let core = Arc::new(Self {
            feeds,
            sender,
            inlet: Arc::new(inlet),
            matches,
            graph,
            dds,
            _farewell: Farewell {
                participant: ourselves,
                domain: domain.number,
                addresses: domain.addresses(),
            },
            tally,
            options: options.clone(),
            masquerades: Masquerades::new(options),
        });
        core.announcer()();
        Ok(core)
    }

    pub(crate) fn orders(&self) -> &Orders {
        self.sender.orders()
    }

    /// A function that schedules an announcement of our ends.
    pub(crate) fn announcer(&self) -> Box<dyn Fn() + Send + Sync> {
        let orders = self.orders().clone();
        Box::new(move || orders.announce())
    }

    /// The ROS name of an address without its leading slash, as messages and lists show it.
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

    pub(crate) fn port(
        &self,
        kind: EndpointKind,
        at: &Address,
        ty: &DataType,
    ) -> Result<Wanted, OpenError> {
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
                // The address is the writer's; which component reads is not known here.
                EndpointKind::Subscription => format!("genomd_{}", std::process::id()),
                _ => names::token(&at.instance),
            },
        })
    }

    pub(crate) fn failed(&self, at: &Address, why: impl std::fmt::Display) -> OpenError {
        OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why: why.to_string() }
    }

    /// The reader of a topic, shared by all in ports of this daemon that read it.
    pub(crate) fn feed(
        &self,
        wanted: &Wanted,
        ty: &DataType,
        quality: &Quality,
    ) -> CreateResult<Arc<FeedHandle>> {
        let wish = Wish::new(quality, &self.options.qos);
        self.feeds.get(&wanted.topic, wish, || {
            let ourselves = self.dds.participant.guid();
            let feed = Feed::new(wanted, Arc::clone(&self.graph), ourselves);
            let by = (&self.inlet, &self.dds);
            FeedHandle::open(feed, (wish, samples_of(ty)), by, self.announcer())
        })
    }

    /// What is needed to create the ends of services.
    pub(crate) fn maker(&self) -> Maker {
        Maker {
            inlet: Arc::clone(&self.inlet),
            orders: self.orders().clone(),
            matches: Arc::clone(&self.matches),
            mapping: self.options.services,
        }
    }
}

/// Number of samples of a type that fit into [`MEMORY`].
pub(crate) fn samples_of(ty: &DataType) -> i32 {
    let size = if ty.is_fixed_size() { ty.size().max(1) } else { MEMORY / 64 };
    i32::try_from((MEMORY / size).clamp(4, 1024)).unwrap_or(4)
}
