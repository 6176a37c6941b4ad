//! Ports on a middleware: what is opened, how it is read, and the two ends.

use genom_types::{DataType, Record};

use crate::{Address, OpenError, PublishError, Quality, ReadError};

/// A port to be opened: where it is, what it carries, and in what quality.
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
    /// Of the out port, also for those who read it.
    pub address: &'a Address,
    /// Type of the samples.
    pub ty: &'a DataType,
    /// What is asked of this end, where the middleware leaves a choice.
    pub quality: Quality,
}

impl<'a> PortSpec<'a> {
    /// A port in the quality that the middleware is configured for.
    #[must_use]
    pub fn new(address: &'a Address, ty: &'a DataType) -> Self {
        Self { address, ty, quality: Quality::default() }
    }

    /// The same port in this quality.
    #[must_use]
    pub fn of(self, quality: Quality) -> Self {
        Self { quality, ..self }
    }
}

/// What a reader wants of the samples it has not read yet.
///
/// Whatever the policy, a new reader starts with the last value, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// The newest value only: the semantics of GenoM ports.
    #[default]
    Latest,
    /// Oldest first, at most this many unread; when full, new samples are dropped and counted.
    Queue(usize),
    /// Oldest first, at most this many unread; when full, the oldest are overwritten and counted.
    Ring(usize),
}

/// What a read found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// A sample that had not been read before is now in the record.
    New,
    /// Nothing new: the record still holds the last value.
    Same,
    /// Nothing was ever published.
    Never,
}

/// Opens ports: what every middleware can.
pub trait Ports {
    /// Opens the writing end of a port. It shows at once; its value is undefined until written.
    ///
    /// # Errors
    /// When the address is taken, the type differs from a reader's, or the middleware fails.
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError>;

    /// Opens the reading end of a port. The writer may come later, go and come back.
    ///
    /// # Errors
    /// When the writer's type differs (both are named), or the middleware fails.
    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError>;
}

/// The writing end of an out port (or of one element of a multiple port).
///
/// The last value is offered to late readers as long as the publisher lives. Dropping it frees
/// the address; readers keep what they have read.
pub trait Publisher: Send {
    /// Publishes a copy of the value; a reader that comes later still sees it.
    ///
    /// Real-time: a bounded copy, no blocking, and no allocation of ours for types of fixed size.
    ///
    /// # Errors
    /// When the value has no encoding or the middleware refuses it; nothing was published then.
    fn publish(&mut self, value: &Record) -> Result<(), PublishError>;

    /// Samples given up so far because the middleware did not keep up.
    fn dropped(&self) -> u64;
}

/// The reading end of an in port (or of one element of a multiple port).
pub trait Subscription: Send {
    /// Puts the next value, by the connection's policy, into `into`.
    ///
    /// Real-time as [`Publisher::publish`]. `into` is of the type the subscription was opened
    /// with, and is left alone unless the result is [`Reading::New`].
    ///
    /// # Errors
    /// When the sample is not decodable or the middleware fails.
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError>;

    /// Samples lost so far: overwritten (ring), refused (queue) or undecodable.
    fn dropped(&self) -> u64;
}
