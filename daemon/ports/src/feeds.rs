//! Publishers of the daemon itself for in ports: values published by a client, without an out port.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use genom_middleware::Publisher;
use genom_types::Record;

use crate::key::PortKey;

/// The daemon's own publishers for the in ports of one component.
///
/// They are locked by whoever changes what an in port reads, so that such changes happen one after
/// the other.
#[derive(Default)]
pub struct Feeds(Mutex<BTreeMap<PortKey, Feed>>);

/// The daemon's publisher for one in port.
pub struct Feed {
    /// Publishes under the in port's own address.
    pub publisher: Box<dyn Publisher>,
    /// The value published last. Members that the next value leaves out keep the values they have
    /// here.
    pub value: Record,
}

impl Feeds {
    /// Closes all publishers.
    pub fn close_all(&self) {
        self.hold(BTreeMap::clear);
    }

    /// Calls `work` with the publishers locked: meanwhile nobody else changes what in ports of the
    /// component read.
    pub fn hold<T>(&self, work: impl FnOnce(&mut BTreeMap<PortKey, Feed>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl std::fmt::Debug for Feeds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.hold(|feeds| feeds.keys().cloned().collect::<Vec<_>>())).finish()
    }
}
