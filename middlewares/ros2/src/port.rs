//! In ports as the runtime sees them, and the sizes of buffers of out ports.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_kit::intake::Intake;
use genom_middleware::{ReadError, Reading, Subscription};
use genom_types::{DataType, Record};

use crate::inbox::Inbox;

/// Limit in bytes for the samples of an out port that wait to be sent.
const WAITING: usize = 4 << 20;

/// Initial buffer size in bytes for a message of the type.
pub(crate) fn room_for(ty: &DataType) -> usize {
    if ty.is_fixed_size() { ty.size() + ty.size() / 8 + 64 } else { 256 }
}

/// Number of samples that may wait to be sent: fewer if they are large, since their buffers are
/// preallocated.
pub(crate) fn depth_of(ty: &DataType, wanted: usize) -> usize {
    wanted.min((WAITING / room_for(ty)).max(1))
}

/// An in port. Fields are dropped in order.
pub(crate) struct InPort {
    intake: Intake,
    inbox: Arc<Inbox>,
    /// Told of samples that cannot be decoded; wait-free.
    complain: Box<dyn Fn() + Send + Sync>,
    /// Keeps it subscribed and registered.
    _held: Box<dyn Send>,
}

impl InPort {
    pub(crate) fn new(
        ty: &DataType,
        inbox: Arc<Inbox>,
        complain: Box<dyn Fn() + Send + Sync>,
        held: Box<dyn Send>,
    ) -> Self {
        Self { intake: Intake::new(ty), inbox, complain, _held: held }
    }

    fn counted(&self, reading: Result<Reading, ReadError>) -> Result<Reading, ReadError> {
        if reading == Err(ReadError::Serialization) {
            self.inbox.undecodable.fetch_add(1, Ordering::Relaxed);
            (self.complain)();
        }
        reading
    }
}

impl Subscription for InPort {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let mailbox = &self.inbox.mailbox;
        let reading = self.intake.read(into, |decode| mailbox.take(|message| message.read(decode)));
        self.counted(reading)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        let mailbox = &self.inbox.mailbox;
        let reading =
            self.intake.read_message(into, |see| mailbox.take(|message| message.read(see)));
        Some(self.counted(reading))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.told.0.set(told).is_ok()
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        self.inbox.lost()
    }
}
