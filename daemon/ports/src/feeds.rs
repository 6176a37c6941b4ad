//! The daemon's own publishers at in ports, as state; `wiring::feed` publishes with them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use genom_middleware::Publisher;
use genom_types::Record;

use crate::key::PortKey;

/// The daemon's own publishers at in ports of one component.
///
/// Who changes what an in port reads holds them: of two who do so at once, the second sees all
/// that the first did.
#[derive(Default)]
pub struct Feeds(Mutex<BTreeMap<PortKey, Feed>>);

/// One of them.
pub struct Feed {
    /// Publishes under the in port's own address.
    pub publisher: Box<dyn Publisher>,
    /// What was published last: members left out of the next value keep theirs.
    pub value: Record,
}

impl Feeds {
    /// Closes all.
    pub fn close_all(&self) {
        self.hold(BTreeMap::clear);
    }

    /// Does `work` while nobody else changes what in ports of the component read.
    pub fn hold<T>(&self, work: impl FnOnce(&mut BTreeMap<PortKey, Feed>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl std::fmt::Debug for Feeds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.hold(|feeds| feeds.keys().cloned().collect::<Vec<_>>())).finish()
    }
}
