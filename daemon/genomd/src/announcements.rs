//! The announcements that make this daemon visible to others on middlewares.

use std::sync::{Mutex, PoisonError};

/// Announcements, each under a name. A middleware withdraws one when its value is dropped.
#[derive(Default)]
pub(crate) struct Announcements(Mutex<Vec<(String, Box<dyn Send + Sync>)>>);

impl Announcements {
    /// Keeps an announcement.
    pub(crate) fn keep(&self, name: String, announcement: Box<dyn Send + Sync>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((name, announcement));
    }

    /// The name that others see; none while nothing is announced.
    pub(crate) fn name(&self) -> Option<String> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.first().map(|(name, _)| name.clone())
    }

    /// Withdraws all of them.
    pub(crate) fn withdraw(&self) {
        let all = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        drop(all);
    }
}
