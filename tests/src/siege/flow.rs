//! How long no sample came through.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::http::attempt;

/// How often to look.
const LOOK: Duration = Duration::from_millis(2);

/// One port, looked at all the time until this is dropped.
#[derive(Debug)]
pub(super) struct Flow {
    seen: Arc<Mutex<Seen>>,
    stop: Arc<AtomicBool>,
    looking: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Seen {
    /// When the value last changed.
    last: Instant,
    /// How often.
    changes: u64,
    longest: Duration,
}

impl Drop for Flow {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(looking) = self.looking.take() {
            let _ = looking.join();
        }
    }
}

impl Flow {
    /// Looks at `COMPONENT/PORT` of the daemon with this socket.
    pub(super) fn of(socket: PathBuf, component: &str, port: &str) -> Self {
        let path = format!("/components/{component}/ports/{port}");
        let begin = Seen { last: Instant::now(), changes: 0, longest: Duration::ZERO };
        let (seen, stop) = (Arc::new(Mutex::new(begin)), Arc::new(AtomicBool::new(false)));
        let (noted, over) = (Arc::clone(&seen), Arc::clone(&stop));
        let look = move || {
            let mut before = Value::Null;
            while !over.load(Ordering::SeqCst) {
                let now =
                    attempt(&socket, "GET", &path, "").map(|reply| reply.body["value"].clone());
                let mut seen = noted.lock().unwrap_or_else(PoisonError::into_inner);
                if let Ok(now) = now
                    && now != before
                {
                    before = now;
                    seen.changes += 1;
                    seen.last = Instant::now();
                } else {
                    seen.longest = seen.longest.max(seen.last.elapsed());
                }
                drop(seen);
                thread::park_timeout(LOOK);
            }
        };
        let looking = Some(thread::spawn(look));
        Self { seen, stop, looking }
    }

    /// How many new values there were.
    pub(super) fn changes(&self) -> u64 {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).changes
    }

    /// The longest time without a new value, since this was last asked.
    pub(super) fn longest(&self) -> Duration {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut seen.longest)
    }
}
