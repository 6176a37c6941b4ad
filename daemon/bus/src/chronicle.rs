//! The changes of the last minutes with their dates, for a timeline. Kept from the first time that
//! somebody asks, for a bounded time and number.

use std::collections::VecDeque;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;

use crate::numbered::Numbered;

/// Changes are kept for this long.
pub const KEPT_FOR: Duration = Duration::from_secs(600);
/// Changes that are kept; of more, the latest. Some 10 MB.
pub const MOST: usize = 16_384;

/// The changes of the last minutes.
#[derive(Debug, Default)]
pub struct Chronicle(OnceLock<Mutex<Kept>>);

#[derive(Debug, Default)]
struct Kept {
    changes: VecDeque<Numbered>,
    /// Since when there is everything.
    since: u64,
}

/// Changes of a chronicle.
#[derive(Debug, Default)]
pub struct Excerpt {
    /// In order of their numbers.
    pub changes: Vec<Numbered>,
    /// Changes after the one asked for that are not kept any more; 0 if none was named.
    pub missed: u64,
    /// How many come after these.
    pub left: usize,
    /// Since when there is everything: see `Dates::moment`.
    pub since: u64,
}

impl Chronicle {
    /// Begins to keep changes, unless it does already. `past` is what is known from before.
    pub(crate) fn begin(&self, moment: u64, past: impl FnOnce() -> VecDeque<Numbered>) {
        self.0.get_or_init(|| {
            let changes = past();
            let since = changes.front().map_or(moment, |first| first.moment);
            Mutex::new(Kept { changes, since })
        });
    }

    /// Keeps a change, if it has begun.
    pub(crate) fn add(&self, change: &Numbered) {
        let Some(kept) = self.0.get() else { return };
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        let oldest = change.moment.saturating_sub(u64::try_from(KEPT_FOR.as_nanos()).unwrap_or(0));
        while kept.changes.front().is_some_and(|first| first.moment < oldest) {
            kept.changes.pop_front();
        }
        kept.since = kept.since.max(oldest);
        if kept.changes.len() >= MOST {
            kept.changes.pop_front();
            kept.since = kept.changes.front().map_or(change.moment, |first| first.moment);
        }
        kept.changes.push_back(change.clone());
    }

    /// At most `most` changes after number `after`.
    pub(crate) fn after(&self, after: u64, most: usize) -> Excerpt {
        let Some(kept) = self.0.get() else { return Excerpt::default() };
        let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        let begin = kept.changes.partition_point(|change| change.id <= after);
        let news = kept.changes.range(begin..);
        let left = news.len().saturating_sub(most);
        let first = news.clone().next().map_or(0, |first| first.id);
        Excerpt {
            changes: news.take(most).cloned().collect(),
            missed: if after == 0 { 0 } else { first.saturating_sub(after.saturating_add(1)) },
            left,
            since: kept.since,
        }
    }
}
