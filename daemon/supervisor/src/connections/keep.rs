//! Looks after connections: those declared are made again when a component or another daemon comes
//! back, and all follow writers that move to another middleware of the in port's.

use std::time::Duration;

use super::core::{Connections, Wanted};
use crate::flag::Flag;

/// How often missing connections are looked after.
const LOOK: Duration = Duration::from_millis(100);

/// Looks after connections until `stop` is raised.
pub(crate) fn watch(connections: Connections, stop: Flag) -> std::io::Result<()> {
    std::thread::Builder::new().name("genomd-wiring".to_owned()).spawn(move || {
        while !stop.is_up() {
            connections.look();
            std::thread::park_timeout(LOOK);
        }
    })?;
    Ok(())
}

impl Connections {
    /// Makes what is missing, as far as both sides are there.
    fn look(&self) {
        for entry in self.declared.all() {
            // Subscriptions and remotes survive their other side: it is found when it is back.
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
