//! What all ends share: the participant, its threads, and the graph of known ends.

use std::sync::Arc;

use crate::dds::rustdds::RTPSEntity;
use crate::dds::rustdds::dds::CreateResult;
use genom_middleware::Quality;
use genom_rtps_guard::Tally;
use genom_types::DataType;

use crate::dds::channel::Maker;
use crate::dds::farewell::Farewell;
use crate::dds::feed::Feed;
use crate::dds::feeds::{FeedHandle, Feeds};
use crate::dds::graph::{Graph, Wanted};
use crate::dds::info;
use crate::dds::news::news;
use crate::dds::participant::Dds;
use crate::dds::post::Matches;
use crate::dds::process::Process;
use crate::dds::quality::Wish;
use crate::dds::receiver::Inlet;
use crate::dds::reunions::Reunions;
use crate::dds::sender::{Orders, Sending};
use crate::dds::told::{Hear, Told};
use crate::dds::wire;
use crate::domain::Domain;
use crate::error::ParticipantError;
use crate::options::Options;

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
}

impl Core {
    /// Joins a domain.
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, ParticipantError> {
        options.check()?;
        let domain = Domain::of(options)?;
        let failed = |why| ParticipantError::Dds { domain: domain.number, why };
        let tally = genom_rtps_guard::guard(domain.number, options.limits());
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
