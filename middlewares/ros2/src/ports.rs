//! The ends of ports, as the runtime sees them.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_middleware::mailbox::PutError;
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_types::{DataType, Record};
use rustdds::GUID;

use crate::backend::Core;
use crate::feed::{FeedHandle, Inbox};
use crate::graph::Claim;
use crate::sender::Outlet;

/// An out port.
pub(crate) struct Ros2Publisher {
    pub(crate) ty: DataType,
    pub(crate) outlet: Arc<Outlet>,
    pub(crate) writer: GUID,
    /// What shows it to others; goes after the last sample went out.
    pub(crate) claim: Option<Claim>,
    pub(crate) core: Arc<Core>,
}

impl Publisher for Ros2Publisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.ty) {
            return Err(PublishError::Refused);
        }
        let put = self.outlet.mailbox.put(|message| value.encode_message(message));
        put.map_err(|error| match error {
            PutError::Fill(_) => PublishError::Serialization,
            PutError::Busy => PublishError::Refused,
        })?;
        self.core.orders().mark(&self.outlet);
        Ok(())
    }

    fn dropped(&self) -> u64 {
        self.outlet.mailbox.lost() + self.outlet.refused.load(Ordering::Relaxed)
    }
}

impl Drop for Ros2Publisher {
    fn drop(&mut self) {
        self.core.orders().remove(self.writer);
        self.core.matches.forget(&self.writer);
        self.claim = None;
    }
}

/// An in port. Fields are dropped in order.
pub(crate) struct Ros2Subscription {
    /// Samples are decoded here first: one that fails leaves the reader's record alone.
    pub(crate) scratch: Record,
    pub(crate) inbox: Arc<Inbox>,
    /// Whether anything was read yet.
    pub(crate) read: bool,
    pub(crate) _feed: Arc<FeedHandle>,
    pub(crate) _claim: Claim,
    pub(crate) core: Arc<Core>,
}

impl Subscription for Ros2Subscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if !into.ty().same_as(self.scratch.ty()) {
            return Err(ReadError::Broken);
        }
        let scratch = &mut self.scratch;
        let decoded =
            self.inbox.mailbox.take(|message| into.replace_from_message(message, scratch).is_ok());
        match decoded {
            None if self.read => Ok(Reading::Same),
            None => Ok(Reading::Never),
            Some(false) => {
                self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
                self.core.orders().complain();
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
