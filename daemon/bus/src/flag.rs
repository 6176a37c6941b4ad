//! A one-time signal that can be waited for.

use std::sync::Arc;

use tokio::sync::watch;

/// A flag that is raised once and never lowered; clones share the flag.
#[derive(Clone, Debug)]
pub struct Flag(Arc<watch::Sender<bool>>);

impl Default for Flag {
    fn default() -> Self {
        Self::new()
    }
}

impl Flag {
    /// A flag that is not raised.
    pub fn new() -> Self {
        Self(Arc::new(watch::Sender::new(false)))
    }

    /// Raises the flag. Returns whether this call raised it.
    pub fn raise(&self) -> bool {
        self.0.send_if_modified(|up| !std::mem::replace(up, true))
    }

    /// Whether the flag is raised.
    pub fn is_up(&self) -> bool {
        *self.0.borrow()
    }

    /// Waits until the flag is raised.
    pub async fn raised(&self) {
        // Cannot fail: the sender lives in `self`.
        let _ = self.0.subscribe().wait_for(|up| *up).await;
    }
}
