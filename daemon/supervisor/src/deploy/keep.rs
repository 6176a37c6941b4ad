//! Looks after connections: those declared are made again when a component or another daemon comes
//! back, and all follow writers that move to another middleware of the in port's.

use std::sync::{Arc, Weak};
use std::time::Duration;

use super::link::{self, Link};
use crate::daemon::Daemon;
use crate::wiring::switch;

/// How often missing connections are looked after.
const LOOK: Duration = Duration::from_millis(100);

/// Looks after connections until the daemon stops.
pub fn watch(daemon: &Arc<Daemon>) -> std::io::Result<()> {
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
