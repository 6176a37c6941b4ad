//! The daemons that are visible on this middleware, by their liveliness tokens.

use std::collections::BTreeSet;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use genom_middleware::AnnounceError;

use crate::error::BACKEND;

/// How long to wait for a daemon that is not visible yet.
const TO_SHOW: Duration = Duration::from_secs(3);

/// The visible daemons, as pairs of session and name.
#[derive(Default)]
pub(crate) struct Daemons {
    there: Mutex<BTreeSet<(String, String)>>,
    changed: Condvar,
}

impl Daemons {
    /// A daemon appeared or disappeared. `own` is this session.
    pub(crate) fn heard(&self, session: String, name: String, came: bool, own: &str) {
        let mut there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        // Two daemons of one name: they started at the same time, or while the network was down,
        // and could not see each other.
        if came && session != own && there.contains(&(own.to_owned(), name.clone())) {
            let backend = BACKEND.to_owned();
            let taken = AnnounceError::Taken { name: name.clone(), backend };
            tracing::warn!("{taken}; until then requests may reach either");
        }
        if came {
            there.insert((session, name));
        } else {
            there.remove(&(session, name));
        }
        self.changed.notify_all();
    }

    /// Whether a daemon is visible in that session.
    pub(crate) fn has(&self, wanted: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        there.iter().any(|(session, _)| session == wanted)
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        let names: BTreeSet<_> = there.iter().map(|(_, name)| name.clone()).collect();
        names.into_iter().collect()
    }

    /// Waits for a daemon of that name. Returns whether one is visible.
    pub(crate) fn wait_for(&self, wanted: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        let absent =
            |there: &mut BTreeSet<(String, String)>| !there.iter().any(|(_, name)| name == wanted);
        let waited = self.changed.wait_timeout_while(there, TO_SHOW, absent);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Whether another session has a daemon of that name.
    pub(crate) fn taken(&self, wanted: &str, own: &str) -> bool {
        let there = self.there.lock().unwrap_or_else(PoisonError::into_inner);
        there.iter().any(|(session, name)| name == wanted && session != own)
    }
}
