//! Looks after connections: those declared are made again when a component or another daemon comes
//! back, and all follow writers that move to another middleware of the in port's.

use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use super::link::{self, Link};
use crate::config::ConnectionEntry;
use crate::daemon::Daemon;
use crate::wiring::switch;

/// How often missing connections are looked after.
const LOOK: Duration = Duration::from_millis(100);

/// The connections that deployments declared, one an in port or remote.
#[derive(Debug, Default)]
pub(crate) struct Declared {
    entries: Mutex<Vec<ConnectionEntry>>,
}

impl Declared {
    /// These are to be kept from now on, in place of others of the same in ports.
    pub(crate) fn keep(&self, new: &[ConnectionEntry]) {
        self.with(|entries| {
            entries.retain(|old| !new.iter().any(|entry| entry.inport == old.inport));
            entries.extend_from_slice(new);
        });
    }

    /// Somebody disconnected or connected this in port or remote otherwise: that holds.
    pub(crate) fn forget(&self, inport: &str) {
        self.with(|entries| entries.retain(|entry| entry.inport != inport));
    }

    /// All of them.
    pub(crate) fn all(&self) -> Vec<ConnectionEntry> {
        self.with(|entries| entries.clone())
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<ConnectionEntry>) -> T) -> T {
        work(&mut self.entries.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Looks after connections until the daemon stops.
pub(crate) fn watch(daemon: &Arc<Daemon>) -> std::io::Result<()> {
    let daemon = Arc::downgrade(daemon);
    std::thread::Builder::new().name("genomd-wiring".to_owned()).spawn(move || {
        while look(&daemon) {
            std::thread::park_timeout(LOOK);
        }
    })?;
    Ok(())
}

/// Makes what is missing, as far as both sides are there; false when the daemon stops.
fn look(daemon: &Weak<Daemon>) -> bool {
    let Some(daemon) = daemon.upgrade() else { return false };
    if daemon.stopping() {
        return false;
    }
    for entry in daemon.declared.all() {
        // Subscriptions and remotes survive their other side: it is found when it is back.
        if daemon.components.get(entry.reader()).is_none()
            || Link::present(&daemon, &entry.inport).is_some()
        {
            continue;
        }
        match link::make(&daemon, &entry) {
            Ok(()) => tracing::info!("connected {entry} again"),
            Err(error) => tracing::debug!("connect {entry}: {}", error.why),
        }
    }
    switch::catch_up(&daemon);
    true
}
