//! Ports on a middleware: what is needed to open one, how samples are read, and its two ends.

use genom_types::{DataType, Record};
use serde::{Deserialize, Serialize};

use crate::{Address, OpenError, PublishError, Quality, ReadError};

/// A port to be opened: its address, the type of its samples, and its quality of service.
///
/// ```
/// use std::sync::Arc;
/// use genom_middleware::{Address, PortSpec, Quality};
/// use genom_types::{DataType, Kind, TypeTable};
///
/// let mut types = TypeTable::default();
/// let double = types.add(Kind::Double);
/// let ty = DataType::new(&Arc::new(types), double)?;
/// let at = Address::new("arm", "angle");
/// let port = PortSpec::new(&at, &ty).of(Quality { reliable: Some(false), ..Quality::default() });
/// assert_eq!(port.quality.reliable, Some(false));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PortSpec<'a> {
    /// Address of the out port, for the writing and for the reading end alike.
    pub address: &'a Address,
    /// Type of the samples.
    pub ty: &'a DataType,
    /// Quality of service of this end, on middlewares that offer a choice.
    pub quality: Quality,
}

impl<'a> PortSpec<'a> {
    /// A port with the quality of service that the middleware is configured for.
    #[must_use]
    pub fn new(address: &'a Address, ty: &'a DataType) -> Self {
        Self { address, ty, quality: Quality::default() }
    }

    /// The same port with another quality of service.
    #[must_use]
    pub fn of(self, quality: Quality) -> Self {
        Self { quality, ..self }
    }
}

/// Which of the unread samples a reader gets, and how many of them are kept.
///
/// Under each policy a new reader starts with the last value, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Policy {
    /// Only the newest value, as GenoM3 ports do.
    #[default]
    Latest,
    /// Oldest first; keeps at most this many unread samples. When full, new samples are dropped and
    /// counted.
    Queue(usize),
    /// Oldest first; keeps at most this many unread samples. When full, the oldest are overwritten
    /// and counted.
    Ring(usize),
}

/// Result of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The record now holds a sample that had not been read before.
    New,
    /// There is no new sample; the record still holds the last value.
    Same,
    /// Nothing has been published yet.
    Never,
}

/// Opens ports. Every middleware implements this.
pub trait Ports {
    /// Opens the writing end of a port. The port is visible to others at once and has no value
    /// until the first [`publish`](Publisher::publish).
    ///
    /// # Errors
    /// The address is taken, a reader has another type, or the middleware fails.
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError>;

    /// Opens the reading end of a port. The writer may appear later, disappear and come back.
    ///
    /// # Errors
    /// The writer has another type (the message names both), or the middleware fails.
    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError>;
}

/// The writing end of an out port, or of one element of a multiple port.
///
/// New readers get the last value for as long as the publisher exists. Dropping it frees the
/// address; readers keep the value that they have read.
pub trait Publisher: Send {
    /// Publishes a copy of the value, which readers that are opened later get as well.
    ///
    /// Real-time: copies a bounded amount, does not block and, for types of fixed size, allocates
    /// nothing in our own code.
    ///
    /// # Errors
    /// The value cannot be encoded, or the middleware refuses it. Nothing was published then.
    fn publish(&mut self, value: &Record) -> Result<(), PublishError>;

    /// Publishes a sample that is a message in CDR, as
    /// [`Record::encode_message`](genom_types::Record::encode_message) makes it: for who passes
    /// samples on. One that is no value of the port's type is refused. `None` if this middleware
    /// takes records only; nothing was published then.
    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        let _ = message;
        None
    }

    /// Number of samples dropped so far because the middleware could not keep up.
    fn dropped(&self) -> u64;
}

/// The reading end of an in port (or of one element of a multiple port).
pub trait Subscription: Send {
    /// Copies the next sample according to the connection's policy into `into`.
    ///
    /// Real-time in the same sense as [`Publisher::publish`]. `into` must have the type that the
    /// subscription was opened with, and is unchanged unless the result is [`Reading::New`].
    ///
    /// # Errors
    /// The sample cannot be decoded, or the middleware fails.
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError>;

    /// Replaces `into` by the next sample, as a message in CDR; else as [`read`](Self::read), whose
    /// results it shares. `None` if this middleware gives records only; nothing was read then.
    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        let _ = into;
        None
    }

    /// From now on, calls `told` after each sample that arrives, on a thread of the middleware;
    /// `told` does not block. A sample that arrived before is not told. Returns whether this
    /// middleware tells at all: it need not, since codels read when they run.
    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        let _ = told;
        false
    }

    /// When the sample arrived that was read last, on `CLOCK_MONOTONIC` in nanoseconds: from then
    /// on a read would have found it. `None` if this middleware does not know, or if a sample can
    /// be read as soon as `publish` has returned.
    fn arrived(&self) -> Option<u64> {
        None
    }

    /// Number of samples lost so far: overwritten (ring), dropped (queue) or not decodable.
    fn dropped(&self) -> u64;
}
