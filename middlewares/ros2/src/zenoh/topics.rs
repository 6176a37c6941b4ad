//! Topics that are no ports: feedback and status of actions.

use std::sync::{Arc, Mutex};

use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

use super::attachment::Attachment;
use super::core::{Core, Shown};
use super::keys::{self, Kind};
use super::numbers::Numbers;
use super::quality::Quality;
use super::sending::{Numbered, Orders};
use super::services::message;
use crate::lock::lock;
use crate::rmw::{EndError, Entities, Gid, Named, OnMessage, TopicWriter};

/// The writing end of a topic.
pub(crate) struct Writing {
    gid: Gid,
    publisher: Arc<Mutex<Numbered>>,
    orders: Orders,
    _shown: Shown,
}

impl Writing {
    pub(crate) fn open(
        core: &Core,
        node: &str,
        of: &Named,
        latched: bool,
    ) -> Result<Self, EndError> {
        let quality = Quality {
            transient_local: latched,
            depth: if latched { 1 } else { 10 },
            reliable: true,
        };
        let draft = core.draft(node, Kind::Publisher, of, quality)?;
        let publisher = core.declare(keys::of(core.domain, of)?, quality, false)?;
        let last = Attachment { number: 0, gid: draft.gid };
        Ok(Self {
            gid: draft.gid,
            publisher: Arc::new(Mutex::new(Numbered { publisher, last })),
            orders: core.orders().clone(),
            _shown: core.show(&draft)?,
        })
    }
}

impl TopicWriter for Writing {
    fn entities(&self) -> Entities {
        Entities { writers: vec![self.gid], readers: Vec::new() }
    }

    // A topic of zenoh has no single reader.
    fn send(&self, _: Option<Gid>, body: Vec<u8>) {
        let publisher = Arc::clone(&self.publisher);
        self.orders.submit(move |_, _| {
            if let Err(error) = lock(&publisher).put(message(&body)) {
                tracing::warn!(%error, "zenoh refused the state of an activity");
            }
        });
    }

    fn flush(&self) {
        self.orders.finish(|_, _| {});
    }
}

/// The reading end of a topic. Fields are dropped in order.
pub(crate) struct Reading {
    _subscribers: [Subscriber<()>; 2],
    _shown: Shown,
}

impl Reading {
    pub(crate) fn open(
        core: &Core,
        node: &str,
        of: &Named,
        on_message: OnMessage,
    ) -> Result<Self, EndError> {
        let draft = core.draft(node, Kind::Subscription, of, Quality::SERVICE)?;
        let draft = draft.with_buffers(core.domain);
        let (numbers, on_message) =
            (Arc::new(Mutex::new(Numbers::default())), Arc::new(on_message));
        let subscriber = |key: String| {
            let (numbers, on_message) = (Arc::clone(&numbers), Arc::clone(&on_message));
            let arrives = move |sample: Sample| {
                let attachment = sample.attachment().and_then(Attachment::decode);
                let is_new = attachment.is_none_or(|one| lock(&numbers).admit(one).is_some());
                if sample.kind() == SampleKind::Put && is_new {
                    on_message(&sample.payload().to_bytes());
                }
            };
            core.session().declare_subscriber(key).callback(arrives).wait()
        };
        // Whatever the name of the type is in other daemons.
        let key = format!("{}/{}/*/*", core.domain, of.name);
        let subscribers = [subscriber(keys::of_buffers(&key))?, subscriber(key)?];
        Ok(Self { _subscribers: subscribers, _shown: core.show(&draft)? })
    }
}
