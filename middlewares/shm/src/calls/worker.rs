//! The thread that passes on requests and responses.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use genom_middleware::{Address, OpenError};

use super::bell::{Bell, lock};
use super::call::Call;
use super::callers::Callers;
use super::hub::Hub;
use crate::error::failed;
use crate::ground::Ground;

/// Name of the event that wakes all daemons with the same prefix.
const WAKE: &str = "genom.wake";
/// Greatest number of daemons on one machine.
const DAEMONS: usize = 64;
/// How often the thread polls without being woken, to notice peers that were killed.
const PERIOD: Duration = Duration::from_millis(200);

pub(crate) struct Worker {
    pub(super) callers: Callers,
    shared: Arc<Shared>,
    bell: Arc<Bell>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    /// Created when the first service is served.
    hub: Mutex<Option<Arc<Hub>>>,
    calls: Mutex<Vec<Arc<Call>>>,
    stop: AtomicBool,
}

impl Worker {
    pub(crate) fn start(ground: &Arc<Ground>, at: &Address) -> Result<Self, OpenError> {
        let name = Ground::service_name(WAKE, at)?;
        let event = ground
            .node
            .service_builder(&name)
            .event()
            .max_listeners(DAEMONS)
            .max_notifiers(DAEMONS)
            .max_nodes(DAEMONS)
            .open_or_create()
            .map_err(|error| failed(at, &error.to_string()))?;
        let listener =
            event.listener_builder().create().map_err(|error| failed(at, &error.to_string()))?;
        let notifier =
            event.notifier_builder().create().map_err(|error| failed(at, &error.to_string()))?;
        let shared = Arc::new(Shared::default());
        let (own, ground) = (Arc::clone(&shared), Arc::clone(ground));
        let thread = thread::Builder::new()
            .name("shm-calls".to_owned())
            .spawn(move || {
                while !own.stop.load(Ordering::SeqCst) {
                    let mut rang = false;
                    let waited = listener.timed_wait(|_| rang = true, PERIOD);
                    if waited.is_err() {
                        thread::park_timeout(PERIOD);
                    }
                    if !rang && !lock(&own.calls).is_empty() {
                        ground.watcher.heal_dead();
                    }
                    own.work();
                }
            })
            .map_err(|error| failed(at, &error.to_string()))?;
        let (bell, thread) = (Arc::new(Bell(notifier)), Some(thread));
        Ok(Self { callers: Callers::default(), shared, bell, thread })
    }

    pub(super) fn bell(&self) -> &Arc<Bell> {
        &self.bell
    }

    /// The serving side; creates it if necessary.
    pub(super) fn hub(&self, ground: &Arc<Ground>, at: &Address) -> Result<Arc<Hub>, OpenError> {
        let mut hub = lock(&self.shared.hub);
        if let Some(hub) = &*hub {
            return Ok(Arc::clone(hub));
        }
        Ok(Arc::clone(hub.insert(Arc::new(Hub::open(ground, &self.bell, at)?))))
    }

    pub(super) fn add_call(&self, call: Arc<Call>) {
        lock(&self.shared.calls).push(call);
    }
}

impl Shared {
    /// Passes on everything that arrived. Holds no lock while foreign code runs.
    fn work(&self) {
        let hub = lock(&self.hub).clone();
        if let Some(hub) = hub {
            hub.work();
        }
        let calls = lock(&self.calls).clone();
        for call in calls {
            if call.work() {
                lock(&self.calls).retain(|other| !Arc::ptr_eq(other, &call));
            }
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        self.bell.ring();
        for call in lock(&self.shared.calls).drain(..) {
            call.lose();
        }
        if let Some(thread) = self.thread.take()
            && thread.thread().id() != thread::current().id()
        {
            let _ = thread.join();
        }
        self.callers.clear();
        // Must be dropped before the node, which others may still hold through it.
        drop(lock(&self.shared.hub).take());
    }
}
