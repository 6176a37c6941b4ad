//! Topics that are no ports: feedback and status of actions.

use std::sync::{Arc, Mutex};

use crate::dds::rustdds::bytes::Bytes;
use crate::dds::rustdds::dds::CreateResult;
use crate::dds::rustdds::mio1::Token;
use crate::dds::rustdds::{RTPSEntity, Timestamp};

use crate::dds::core::Core;
use crate::dds::post::Post;
use crate::dds::receiver::{Inlet, Sample, Sink};
use crate::dds::sender::Orders;
use crate::dds::wire::{self, Payload, Writer};
use crate::lock::lock;
use crate::rmw::{Entities, Gid, Named, OnMessage, Target, TopicWriter};

/// Greatest number of messages of a topic that wait for the receiving thread.
const CACHED: i32 = 1024;

/// The writing end of a topic.
pub(crate) struct Writing {
    way: Way,
    orders: Orders,
}

enum Way {
    /// Messages wait for the reader that they are for.
    Post(Arc<Post>),
    /// DDS keeps the last message for late readers.
    Latched(Arc<Mutex<Writer>>),
}

impl Writing {
    pub(crate) fn open(core: &Core, of: &Named, latched: bool) -> CreateResult<Self> {
        let (topic, ty) = (format!("rt/{}", of.name), of.ty.to_dds(""));
        let writer = core.dds.writer(&topic, &ty, &wire::qos(true, latched, CACHED))?;
        let way = if latched {
            Way::Latched(Arc::new(Mutex::new(writer)))
        } else {
            Way::Post(Post::new(writer, &core.matches, Box::new(|_| {})))
        };
        Ok(Self { way, orders: core.orders().clone() })
    }
}

fn put(writer: &Writer, body: Vec<u8>) {
    if writer.write(Payload(Bytes::from(body)), None).is_err() {
        tracing::warn!("DDS refused the state of an activity");
    }
}

impl TopicWriter for Writing {
    fn entities(&self) -> Entities {
        let guid = match &self.way {
            Way::Post(post) => post.guid(),
            Way::Latched(writer) => lock(writer).guid(),
        };
        Entities { writers: vec![guid.to_bytes()], readers: Vec::new() }
    }

    fn send(&self, to: Option<Gid>, body: Vec<u8>) {
        match &self.way {
            Way::Post(post) => {
                let post = Arc::clone(post);
                self.orders.submit(move || {
                    let letter = Box::new(move |writer: &Writer| put(writer, body));
                    match to {
                        Some(asker) => post.send(Target::Beside(asker), letter),
                        None => post.now(letter),
                    }
                });
            }
            Way::Latched(writer) => {
                let writer = Arc::clone(writer);
                self.orders.submit(move || put(&lock(&writer), body));
            }
        }
    }

    fn flush(&self) {
        if let Way::Post(post) = &self.way {
            self.orders.settle(post);
        }
    }
}

/// The reading end of a topic.
pub(crate) struct Reading {
    inlet: Arc<Inlet>,
    token: Token,
}

struct Messages {
    since: Timestamp,
    on_message: OnMessage,
}

impl Sink for Messages {
    fn arrive(&mut self, sample: Sample<'_>) {
        // Earlier samples belong to an earlier reader of the topic.
        if sample.received >= self.since {
            (self.on_message)(sample.message);
        }
    }
}

impl Reading {
    pub(crate) fn open(core: &Core, of: &Named, on_message: OnMessage) -> CreateResult<Self> {
        let (topic, ty) = (format!("rt/{}", of.name), of.ty.to_dds(""));
        let since = Timestamp::now();
        let reader = core.dds.reader(&topic, &ty, &wire::qos(true, false, CACHED))?;
        let token = core.inlet.add(reader, Box::new(Messages { since, on_message }));
        Ok(Self { inlet: Arc::clone(&core.inlet), token })
    }
}

impl Drop for Reading {
    fn drop(&mut self) {
        self.inlet.remove(self.token);
    }
}
