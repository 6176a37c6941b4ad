//! The DDS readers of this daemon: one per topic and requested QoS.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use crate::dds::rustdds::dds::CreateResult;
use crate::dds::rustdds::mio1::Token;
use crate::dds::rustdds::{GUID, QosPolicies};

use crate::dds::feed::{Feed, FeedSink};
use crate::dds::participant::Dds;
use crate::dds::quality::{Asks, Wish};
use crate::dds::receiver::Inlet;
use crate::dds::wire;

/// Keeps a topic subscribed. Dropping the last handle ends the DDS reader.
pub(crate) struct FeedHandle {
    pub(crate) feed: Arc<Feed>,
    wish: Wish,
    /// Greatest number of samples that may wait for the receiving thread.
    cached: i32,
    token: Token,
    reader: Mutex<Present>,
    inlet: Arc<Inlet>,
    /// Schedules an announcement of our ends.
    announce: Box<dyn Fn() + Send + Sync>,
    dds: Arc<Dds>,
}

/// The current DDS reader.
#[derive(Clone, Copy, Debug)]
struct Present {
    guid: GUID,
    asks: Asks,
}

impl FeedHandle {
    pub(crate) fn open(
        feed: Feed,
        (wish, cached): (Wish, i32),
        (inlet, dds): (&Arc<Inlet>, &Arc<Dds>),
        announce: Box<dyn Fn() + Send + Sync>,
    ) -> CreateResult<Self> {
        let asks = feed.asks(wish);
        let qos = wire::qos(asks.reliable, asks.transient_local, cached);
        let reader = dds.reader(&feed.topic, &feed.dds_type, &qos)?;
        let guid = reader.guid();
        let feed = Arc::new(feed);
        Ok(Self {
            token: inlet.add(reader, Box::new(FeedSink(Arc::clone(&feed)))),
            feed,
            wish,
            cached,
            reader: Mutex::new(Present { guid, asks }),
            inlet: Arc::clone(inlet),
            announce,
            dds: Arc::clone(dds),
        })
    }

    fn present(&self) -> MutexGuard<'_, Present> {
        self.reader.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The QoS that the reader requests.
    pub(crate) fn qos(&self) -> QosPolicies {
        let Asks { reliable, transient_local } = self.present().asks;
        wire::qos(reliable, transient_local, self.cached)
    }

    /// Passes the GUID of the reader to `told`; it does not change before `told` returns.
    pub(crate) fn guid(&self, told: impl FnOnce(GUID)) {
        told(self.present().guid);
    }

    /// Recreates the reader if the existing writers offer another QoS than it requests. Samples
    /// that arrive at the old reader meanwhile are not lost: the new one finds them in DDS's cache.
    fn follow(&self) {
        let asks = self.feed.asks(self.wish);
        let mut present = self.present();
        if present.asks == asks {
            return;
        }
        let (topic, ty) = (&self.feed.topic, &self.feed.dds_type);
        let qos = wire::qos(asks.reliable, asks.transient_local, self.cached);
        match self.dds.reader(topic, ty, &qos) {
            Ok(reader) => {
                let old = std::mem::replace(&mut *present, Present { guid: reader.guid(), asks });
                self.feed.graph.renamed(old.guid, reader.guid());
                self.inlet.exchange(self.token, reader);
                (self.announce)();
                tracing::info!(%topic, ?asks, "the in port follows the quality of its writers");
            }
            Err(why) => tracing::warn!(%topic, %why, "a reader cannot be made anew"),
        }
    }
}

impl Drop for FeedHandle {
    fn drop(&mut self) {
        self.inlet.remove(self.token);
    }
}

/// The topics that this daemon reads, by requested QoS.
#[derive(Default)]
pub(crate) struct Feeds(Mutex<HashMap<String, Vec<Weak<FeedHandle>>>>);

impl Feeds {
    fn lock(&self) -> MutexGuard<'_, HashMap<String, Vec<Weak<FeedHandle>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The feed of a topic; creates it if necessary.
    pub(crate) fn get(
        &self,
        topic: &str,
        wish: Wish,
        make: impl FnOnce() -> CreateResult<FeedHandle>,
    ) -> CreateResult<Arc<FeedHandle>> {
        let mut feeds = self.lock();
        // Dropped after the lock is released, because dropping the last handle of a feed takes the
        // lock.
        let there: Vec<_> =
            feeds.get(topic).into_iter().flatten().filter_map(Weak::upgrade).collect();
        if let Some(feed) = there.iter().find(|feed| feed.wish == wish) {
            let feed = Arc::clone(feed);
            drop(feeds);
            return Ok(feed);
        }
        feeds.retain(|_, all| {
            all.retain(|feed| feed.strong_count() > 0);
            !all.is_empty()
        });
        let handle = Arc::new(make()?);
        feeds.entry(topic.to_owned()).or_default().push(Arc::downgrade(&handle));
        drop(feeds);
        Ok(handle)
    }

    /// The feeds of a topic; empty if it is not read.
    pub(crate) fn of(&self, topic: &str) -> Vec<Arc<FeedHandle>> {
        self.lock().get(topic).into_iter().flatten().filter_map(Weak::upgrade).collect()
    }

    /// Writers of a topic have appeared.
    pub(crate) fn follow(&self, topic: &str) {
        self.of(topic).iter().for_each(|handle| handle.follow());
    }

    /// Logs samples that readers could not decode.
    pub(crate) fn complain(&self) {
        let feeds: Vec<_> = self.lock().values().flatten().filter_map(Weak::upgrade).collect();
        feeds.iter().for_each(|handle| handle.feed.complain());
    }

    /// The graph has news of writers.
    pub(crate) fn settle(&self) {
        let feeds: Vec<_> = self.lock().values().flatten().filter_map(Weak::upgrade).collect();
        feeds.iter().for_each(|handle| handle.feed.settle());
    }
}
