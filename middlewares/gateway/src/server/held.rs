//! What proxies have open here, and what is under way for them.

use std::sync::{Arc, Mutex};

use genom_kit::sender;
use genom_middleware::{
    Client, Publisher, ReadError, Reading, Replies, Running, Served, ServiceType, Subscription,
};
use genom_types::{DataType, Record};

use super::mouth::Mouth;
use crate::words::Down;

/// The calling end of a service.
pub(super) type Calling = Arc<Mutex<(Box<dyn Client>, ServiceType)>>;

/// What a proxy has open.
pub(super) enum End {
    /// It is being opened.
    Opening,
    Publisher(Arc<Mutex<Writer>>),
    /// Number of its line.
    Subscription(usize),
    Served(#[allow(dead_code, reason = "withdraws the service when dropped")] Box<dyn Served>),
    Client(Calling),
    Announcement(#[allow(dead_code, reason = "withdraws it when dropped")] Box<dyn Send + Sync>),
}

/// A request that a client of the proxy made; known from before it is sent until it ends.
#[derive(Default)]
pub(super) struct Called {
    pub(super) running: Option<Box<dyn Running>>,
    pub(super) cancelled: bool,
}

/// A request to a service of the proxy's process, or a message to its daemon.
pub(super) enum Asked {
    Request(Arc<Mutex<Option<Box<dyn Replies>>>>, DataType),
    Message(Box<dyn FnOnce(Vec<u8>) + Send>),
}

/// A publisher, and what a sample is decoded into where it has to be.
pub(super) struct Writer {
    end: u32,
    publisher: Box<dyn Publisher>,
    record: Record,
    scratch: Record,
    /// Samples that could not be published.
    refused: u64,
    /// How many the proxy was told to be lost.
    told: u64,
}

impl Writer {
    pub(super) fn new(end: u32, publisher: Box<dyn Publisher>, ty: &DataType) -> Self {
        let (record, scratch) = (Record::new(ty), Record::new(ty));
        Self { end, publisher, record, scratch, refused: 0, told: 0 }
    }

    pub(super) fn write(&mut self, message: &[u8], mouth: &Mouth) {
        if !self.passes(message) {
            self.refused += 1;
        }
        self.tell_lost(mouth);
    }

    /// Publishes a sample: as it is, where the middleware takes that.
    fn passes(&mut self, message: &[u8]) -> bool {
        if let Some(published) = self.publisher.publish_message(message) {
            return published.is_ok();
        }
        let read = self.record.replace_from_message(message, &mut self.scratch);
        read.is_ok() && self.publisher.publish(&self.record).is_ok()
    }

    /// Tells the proxy how many samples are lost, if it does not know.
    pub(super) fn tell_lost(&mut self, mouth: &Mouth) {
        let lost = self.publisher.dropped() + self.refused;
        if lost != self.told {
            self.told = lost;
            mouth.say(&Down::Lost { end: self.end, count: lost }, &[]);
        }
    }
}

/// A subscription, as the sending thread sees it.
pub(super) struct Feed {
    end: u32,
    subscription: Box<dyn Subscription>,
    record: Record,
    message: Vec<u8>,
    mouth: Arc<Mouth>,
    /// How many samples the proxy was told to be lost.
    lost: u64,
}

impl Feed {
    pub(super) fn new(
        end: u32,
        subscription: Box<dyn Subscription>,
        ty: &DataType,
        mouth: &Arc<Mouth>,
    ) -> Self {
        let (record, mouth) = (Record::new(ty), Arc::clone(mouth));
        Self { end, subscription, record, message: Vec::new(), mouth, lost: 0 }
    }
}

impl Feed {
    /// The next sample as a message: as it came, where the middleware gives that.
    fn read(&mut self) -> Result<Reading, ReadError> {
        if let Some(read) = self.subscription.read_message(&mut self.message) {
            return read;
        }
        let read = self.subscription.read(&mut self.record)?;
        if read == Reading::New {
            self.message.clear();
            let encoded = self.record.encode_message(&mut self.message);
            encoded.map_err(|_| ReadError::Serialization)?;
        }
        Ok(read)
    }
}

impl sender::Line for Feed {
    fn send(&mut self) -> bool {
        let read = self.read();
        let lost = self.subscription.dropped();
        if lost != self.lost {
            self.lost = lost;
            self.mouth.say(&Down::Lost { end: self.end, count: lost }, &[]);
        }
        match read {
            Ok(Reading::New) => self.mouth.sample(self.end, &self.message),
            Ok(Reading::Same | Reading::Never) => false,
            // It counts as lost; there may be more.
            Err(_) => true,
        }
    }
}
