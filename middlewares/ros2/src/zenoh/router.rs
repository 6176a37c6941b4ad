//! A router in this process, where no other process is one: through it, the nodes of a machine find
//! each other. Samples do not pass it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use zenoh::{Config, Session, Wait};

use super::session::{apart, open};

/// Time between two attempts, as long as there is no router.
const BETWEEN: Duration = Duration::from_millis(500);

/// Perhaps a router.
pub(crate) struct Router {
    /// `None` if another machine or process has to be it.
    config: Option<Config>,
    running: Mutex<Option<Session>>,
    /// Whether a router is missing.
    sought: AtomicBool,
    /// Whether one was there at the last look.
    seen: AtomicBool,
}

impl Router {
    pub(crate) fn new(config: Option<Config>) -> Self {
        let sought = AtomicBool::new(config.is_some());
        Self { config, running: Mutex::default(), sought, seen: AtomicBool::new(false) }
    }

    /// The router that the session was connected to is gone.
    pub(crate) fn seek(&self) {
        self.seen.store(false, Ordering::Release);
        self.sought.store(self.config.is_some(), Ordering::Release);
    }

    /// Becomes the router if one is missing. Returns the time until the next attempt: what a killed
    /// router had may be in use for a moment longer.
    pub(crate) fn due(&self, session: &Session) -> Option<Duration> {
        if !self.sought.swap(false, Ordering::AcqRel) {
            return None;
        }
        // One that has just gone may still be listed, so it counts when it is seen twice.
        let there = || session.info().routers_zid().wait().next().is_some();
        if self.run() || (there() && self.seen.swap(true, Ordering::AcqRel)) {
            return None;
        }
        self.sought.store(true, Ordering::Release);
        Some(BETWEEN)
    }

    /// Becomes the router, unless somebody else is. Returns whether this process is it.
    pub(crate) fn run(&self) -> bool {
        let Some(config) = &self.config else { return false };
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if running.is_some() {
            return true;
        }
        match open(config.clone()) {
            Ok(session) => {
                tracing::info!("ROS nodes on zenoh find each other through this process");
                *running = Some(session);
            }
            // Usually because its address is in use: by a router.
            Err(why) => tracing::debug!(%why, "this process is no router"),
        }
        running.is_some()
    }
}

impl Drop for Router {
    fn drop(&mut self) {
        let running = self.running.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(session) = running
            && let Some(Err(error)) = apart(|| session.close().wait())
        {
            tracing::warn!(%error, "zenoh did not close");
        }
    }
}
