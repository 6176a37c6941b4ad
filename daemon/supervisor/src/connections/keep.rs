//! Keeps connections up: declared ones are made again when a component or another daemon comes
//! back, and all follow writers that move to another middleware that the in port is on, too.

use std::time::Duration;

use super::core::{Connections, Wanted};
use genom_bus::flag::Flag;

/// How often missing connections are checked.
const LOOK: Duration = Duration::from_millis(100);

/// After how many of these checks the ends of out ports are checked, too.
const ENDS: u64 = 10;

/// Starts the thread that keeps connections up, until `stop` is raised.
pub(crate) fn watch(connections: Connections, stop: Flag) -> std::io::Result<()> {
    std::thread::Builder::new().name("genomd-connect".to_owned()).spawn(move || {
        for round in 1_u64.. {
            if stop.is_up() {
                return;
            }
            connections.look();
            if round % ENDS == 0 {
                connections.keep_ends();
            }
            std::thread::park_timeout(LOOK);
        }
    })?;
    Ok(())
}

impl Connections {
    /// Makes missing connections whose two sides exist.
    fn look(&self) {
        for entry in self.declared.all() {
            // Existing subscriptions and remotes recover by themselves when the other side comes
            // back.
            if self.components.get(entry.reader()).is_none()
                || self.present(&entry.inport).is_some()
            {
                continue;
            }
            match self.make(&Wanted::from(&entry)) {
                Ok(_) => tracing::info!("connected {entry} again"),
                Err(error) => tracing::debug!("connect {entry}: {}", error.sentence()),
            }
        }
        self.catch_up();
    }
}
