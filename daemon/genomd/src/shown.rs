//! What keeps this daemon visible to others on middlewares.

use std::sync::{Mutex, PoisonError};

/// Announcements of this daemon; gone when they are let go.
#[derive(Default)]
pub(crate) struct Shown(Mutex<Vec<(String, Box<dyn Send + Sync>)>>);

impl Shown {
    /// Stays visible under this name.
    pub(crate) fn keep(&self, name: String, announcement: Box<dyn Send + Sync>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((name, announcement));
    }

    /// The name others see, if they see one.
    pub(crate) fn name(&self) -> Option<String> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.first().map(|(name, _)| name.clone())
    }

    /// Others see nothing any more.
    pub(crate) fn let_go(&self) {
        let all = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        drop(all);
    }
}
