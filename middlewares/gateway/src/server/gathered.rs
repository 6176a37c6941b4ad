//! How components fare, of all processes that use the gateway, told together. Each process tells it
//! at its own time: of hundreds of processes, each status would be a message of its own otherwise,
//! and be looked up by itself.

use std::sync::{Arc, Mutex, Weak};
use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::{Diagnosis, Middleware};

use crate::channel::lock;

/// How long the first one waits for others.
const TOGETHER: Duration = Duration::from_millis(200);

/// What waits to be told.
pub(super) struct Gathered {
    /// A thread that waits keeps no middleware open.
    on: Weak<dyn Middleware>,
    waiting: Mutex<Vec<Diagnosis>>,
}

impl Gathered {
    pub(super) fn new(on: &Arc<dyn Middleware>) -> Arc<Self> {
        Arc::new(Self { on: Arc::downgrade(on), waiting: Mutex::default() })
    }

    /// Tells it soon.
    pub(super) fn put(self: &Arc<Self>, mut parts: Vec<Diagnosis>) {
        if parts.is_empty() {
            return;
        }
        let mut waiting = lock(&self.waiting);
        let is_first = waiting.is_empty();
        waiting.append(&mut parts);
        drop(waiting);
        if !is_first {
            return;
        }
        let own = Arc::clone(self);
        let later = move || {
            let end = Instant::now() + TOGETHER;
            while Instant::now() < end {
                thread::park_timeout(end.saturating_duration_since(Instant::now()));
            }
            own.tell();
        };
        if thread::Builder::new().name("gateway-told".to_owned()).spawn(later).is_err() {
            self.tell();
        }
    }

    fn tell(&self) {
        let all = std::mem::take(&mut *lock(&self.waiting));
        if let Some(on) = self.on.upgrade() {
            on.diagnose(&all);
        }
    }
}
