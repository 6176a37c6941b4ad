//! The ends of ports, as the runtime sees them.

use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_types::Record;

use crate::exchange::{Reader, Writer};
use crate::opened::Opened;

/// An out port. Fields are dropped in order: the address is freed after the writer.
pub(crate) struct LocalPublisher {
    pub(crate) writer: Writer,
    pub(crate) _opened: Opened,
}

/// An in port.
pub(crate) struct LocalSubscription {
    pub(crate) reader: Reader,
    pub(crate) _opened: Opened,
}

impl Publisher for LocalPublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        if self.writer.publish(value) { Ok(()) } else { Err(PublishError::Refused) }
    }

    fn dropped(&self) -> u64 {
        self.writer.dropped
    }
}

impl Subscription for LocalSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        self.reader.read(into).ok_or(ReadError::Broken)
    }

    fn dropped(&self) -> u64 {
        self.reader.dropped()
    }
}
