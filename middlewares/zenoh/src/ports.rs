//! The ends of ports, as the runtime sees them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use genom_middleware::mailbox::{Mailbox, PutError};
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_types::{DataType, Record};
use zenoh::query::Queryable;

use crate::backend::Core;
use crate::graph::Claim;
use crate::inbox::Inbox;

/// An out port.
pub(crate) struct ZenohPublisher {
    pub(crate) ty: DataType,
    pub(crate) mailbox: Arc<Mailbox>,
    pub(crate) refused: Arc<AtomicU64>,
    /// Its number with the sending thread.
    pub(crate) line: usize,
    /// What shows it to others; goes after the last sample went out.
    pub(crate) shown: Option<(Queryable<()>, Claim)>,
    pub(crate) core: Arc<Core>,
}

impl Publisher for ZenohPublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.ty) {
            return Err(PublishError::Refused);
        }
        self.mailbox.put(|message| value.encode_message(message)).map_err(|error| match error {
            PutError::Fill(_) => PublishError::Serialization,
            PutError::Busy => PublishError::Refused,
        })?;
        self.core.orders().mark(self.line);
        Ok(())
    }

    fn dropped(&self) -> u64 {
        self.mailbox.lost() + self.refused.load(Ordering::Relaxed)
    }
}

impl Drop for ZenohPublisher {
    fn drop(&mut self) {
        self.core.orders().remove(self.line, self.shown.take());
    }
}

/// An in port. Fields are dropped in order.
pub(crate) struct ZenohSubscription {
    /// Samples are decoded here first: one that fails leaves the reader's record alone.
    pub(crate) scratch: Record,
    pub(crate) inbox: Arc<Inbox>,
    /// Whether anything was read yet.
    pub(crate) read: bool,
    pub(crate) _subscriber: zenoh::pubsub::Subscriber<()>,
    pub(crate) _claim: Claim,
    pub(crate) _core: Arc<Core>,
}

impl Subscription for ZenohSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if !into.ty().same_as(self.scratch.ty()) {
            return Err(ReadError::Broken);
        }
        let scratch = &mut self.scratch;
        let decoded = self.inbox.mailbox.take(|arrival| {
            arrival.read(|message| into.replace_from_message(message, scratch).is_ok())
        });
        match decoded {
            None if self.read => Ok(Reading::Same),
            None => Ok(Reading::Never),
            Some(false) => {
                self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
                Err(ReadError::Serialization)
            }
            Some(true) => {
                self.read = true;
                Ok(Reading::New)
            }
        }
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost()
    }
}
