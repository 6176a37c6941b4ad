//! Other threads that send while a sending thread is blocked.
//!
//! While there is something to send, a watching thread checks the sending thread every [`LOOK`]. If
//! it is still in the same call, another thread takes over its work until the call returns; that
//! thread is watched and relieved in the same way. Relief threads poll every [`ROUND`] instead of
//! waiting for the bell: they are an exception that lasts seconds.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crate::busy::{Busy, is_at_work};
use crate::shared::{Duty, Shared};

/// Time between two checks.
pub(crate) const LOOK: Duration = Duration::from_millis(20);

/// Number of checks without work before the watching thread sleeps.
const QUIET: u32 = 50;

/// Time between two rounds of a relief thread.
const ROUND: Duration = Duration::from_millis(1);

/// Greatest number of relief threads at a time. Beyond it, blocked work waits.
const MOST: usize = 32;

/// A sending thread, and its count at the last check.
struct Seen {
    busy: Arc<Busy>,
    count: u64,
}

impl Seen {
    /// Whether it is in the same call as at the last check.
    fn look(&mut self) -> bool {
        let before = std::mem::replace(&mut self.count, self.busy.count());
        self.count == before && is_at_work(before)
    }
}

/// Watches the sending thread, and starts a relief thread when it is blocked.
pub(crate) fn watch<D: Duty>(shared: &Arc<Shared<D>>, name: &str, first: Arc<Busy>) {
    let mut first = Seen { count: first.count(), busy: first };
    let mut relief: Vec<Seen> = Vec::new();
    let mut quiet = 0;
    while !shared.stops() {
        if quiet >= QUIET {
            shared.alarm.sleep(|| first.busy.count() == first.count && !shared.stops());
            quiet = 0;
        }
        thread::park_timeout(LOOK);
        let before = first.count;
        let held = first.look();
        quiet = if before == first.count && !held { quiet + 1 } else { 0 };
        // A relief thread that has finished has dropped its reference to its count.
        relief.retain(|seen| Arc::strong_count(&seen.busy) > 1);
        let all_held = relief.iter_mut().fold(held, |all, seen| seen.look() && all);
        if !all_held || relief.len() >= MOST {
            continue;
        }
        let busy = Arc::new(Busy::new(&shared.alarm));
        let (own, held, count) = (Arc::clone(&busy), Arc::clone(&first.busy), first.count);
        let shared = Arc::clone(shared);
        let spawned = thread::Builder::new().name(name.to_owned()).spawn(move || {
            shared.sends_here();
            // Until the blocked thread returns from its call.
            while held.count() == count && !shared.stops() {
                let _ = shared.pass(&own);
                thread::park_timeout(ROUND);
            }
        });
        match spawned {
            Ok(_) => relief.push(Seen { count: busy.count(), busy }),
            Err(error) => tracing::warn!(%error, "what is held up cannot be relieved"),
        }
    }
}
