//! What goes on when a sending thread is held up: others send for the rest.
//!
//! A thread of its own looks every [`LOOK`] at what the sending thread is at, as long as that has
//! something to do. One that is still in the middle of the same thing is relieved: another thread
//! does its work until it is back, and is itself relieved in the same way. Those look around every
//! [`ROUND`] instead of being rung for: it is an exception that ends after seconds.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crate::busy::{Busy, is_at_work};
use crate::shared::{Duty, Shared};

/// Time between two looks.
pub(crate) const LOOK: Duration = Duration::from_millis(20);

/// Looks without anything to see before the watching thread sleeps.
const QUIET: u32 = 50;

/// Time between two rounds of a thread that relieves another.
const ROUND: Duration = Duration::from_millis(1);

/// Threads that relieve others at a time. Beyond that, what is held up has to wait.
const MOST: usize = 32;

/// A thread that sends, and what it was at when it was last looked at.
struct Seen {
    busy: Arc<Busy>,
    count: u64,
}

impl Seen {
    /// Whether it is in the middle of the same as before.
    fn look(&mut self) -> bool {
        let before = std::mem::replace(&mut self.count, self.busy.count());
        self.count == before && is_at_work(before)
    }
}

/// Watches the sending thread, and has it relieved when it is held up.
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
        // Those that are through have let go of their count.
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
            // Until who is relieved is back.
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
