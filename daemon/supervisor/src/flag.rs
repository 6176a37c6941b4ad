//! Something that happens once, and can be waited for.

use std::sync::Arc;

use tokio::sync::watch;

/// A flag that is raised once and stays up; clones are the same flag.
#[derive(Clone, Debug)]
pub struct Flag(Arc<watch::Sender<bool>>);

impl Default for Flag {
    fn default() -> Self {
        Self::new()
    }
}

impl Flag {
    /// A flag that is down.
    pub fn new() -> Self {
        Self(Arc::new(watch::Sender::new(false)))
    }

    /// Raises it; whether it was down.
    pub fn raise(&self) -> bool {
        self.0.send_if_modified(|up| !std::mem::replace(up, true))
    }

    /// Whether it is up.
    pub fn is_up(&self) -> bool {
        *self.0.borrow()
    }

    /// Waits until it is up.
    pub async fn raised(&self) {
        // The sender lives in `self`: there is no other outcome.
        let _ = self.0.subscribe().wait_for(|up| *up).await;
    }
}
