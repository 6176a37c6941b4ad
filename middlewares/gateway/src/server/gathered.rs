//! How components fare, of all processes that use the gateway, told together. Each process tells it
//! at its own time: of hundreds of processes, each status would be a message of its own otherwise,
//! and be looked up by itself.

use std::sync::{Arc, Mutex, Weak};
use std::thread;
use std::time::Duration;

use genom_kit::bell::Bell;
use genom_kit::complaints::Complaints;
use genom_middleware::{Diagnosis, Middleware};

use crate::channel::lock;

/// How long the first one waits for others.
const TOGETHER: Duration = Duration::from_millis(200);

/// Most that waits: where a process tells more, or the middleware is slower.
const MOST: usize = 16_384;

/// What waits to be told.
pub(super) struct Gathered {
    /// A thread that waits keeps no middleware open.
    on: Weak<dyn Middleware>,
    waiting: Mutex<Waiting>,
    left_out: Complaints,
}

#[derive(Default)]
struct Waiting {
    parts: Vec<Diagnosis>,
    /// Whether a thread is there that tells it.
    is_told: bool,
}

impl Gathered {
    pub(super) fn new(on: &Arc<dyn Middleware>) -> Arc<Self> {
        let (on, waiting) = (Arc::downgrade(on), Mutex::default());
        Arc::new(Self { on, waiting, left_out: Complaints::new() })
    }

    /// Tells it soon.
    pub(super) fn put(self: &Arc<Self>, mut parts: Vec<Diagnosis>) {
        let mut waiting = lock(&self.waiting);
        let room = MOST - waiting.parts.len();
        if parts.len() > room {
            parts.truncate(room);
            if let Some(count) = self.left_out.add() {
                tracing::warn!(
                    "{MOST} statuses of components wait to be told: further ones are left out \
                     ({count} times)"
                );
            }
        }
        waiting.parts.append(&mut parts);
        if waiting.is_told || waiting.parts.is_empty() {
            return;
        }
        let own = Arc::clone(self);
        let spawned = thread::Builder::new().name("gateway-told".to_owned()).spawn(move || {
            own.tell();
        });
        // Without a thread, the next one who tells something tries again.
        waiting.is_told = spawned.is_ok();
    }

    /// Tells what waits, until nothing does.
    fn tell(&self) {
        // Nobody rings it.
        let pause = Bell::default();
        loop {
            pause.wait(Some(TOGETHER));
            let mut waiting = lock(&self.waiting);
            let all = std::mem::take(&mut waiting.parts);
            waiting.is_told = !all.is_empty();
            drop(waiting);
            if all.is_empty() {
                return;
            }
            if let Some(on) = self.on.upgrade() {
                on.diagnose(&all);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use genom_middleware::{Capabilities, Health, Part};

    use super::*;

    /// Tells how many it was told, and then waits until it may go on.
    struct Slow {
        told: Mutex<Sender<usize>>,
        goes_on: Mutex<Receiver<()>>,
    }

    genom_conformance::portless!(Slow);

    impl Middleware for Slow {
        fn name(&self) -> &'static str {
            "slow"
        }

        fn capabilities(&self) -> Capabilities {
            Capabilities::NETWORK
        }

        fn diagnose(&self, parts: &[Diagnosis]) {
            self.told.lock().unwrap().send(parts.len()).unwrap();
            self.goes_on.lock().unwrap().recv().unwrap();
        }
    }

    fn some(count: usize) -> Vec<Diagnosis> {
        let one = Diagnosis {
            instance: "demo".to_owned(),
            of: Part::Task("main".to_owned()),
            health: Health::Good,
            message: String::new(),
            values: Vec::new(),
        };
        vec![one; count]
    }

    #[test]
    fn a_slow_middleware_is_told_the_rest_once_it_is_done_and_no_more_than_there_is_room_for() {
        let ((told, heard), (go, goes_on)) = (channel(), channel());
        let slow: Arc<dyn Middleware> =
            Arc::new(Slow { told: Mutex::new(told), goes_on: Mutex::new(goes_on) });
        let gathered = Gathered::new(&slow);
        gathered.put(some(1));
        assert_eq!(heard.recv().unwrap(), 1);
        for _ in 0..9 {
            gathered.put(some(MOST / 8));
        }
        go.send(()).unwrap();
        assert_eq!(heard.recv().unwrap(), MOST);
        // As before.
        gathered.put(some(2));
        go.send(()).unwrap();
        assert_eq!(heard.recv().unwrap(), 2);
        go.send(()).unwrap();
    }
}
