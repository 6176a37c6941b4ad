//! One proxy that is connected: what it has open here.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;

use genom_kit::sender::Orders;
use genom_middleware::Middleware;

use super::gathered::Gathered;
use super::held::{Asked, Called, Calling, End, Feed};
use super::mouth::Mouth;
use crate::channel::{Outgoing, lock};
use crate::words::Down;

/// Ends that one process may have open.
pub(super) const ENDS: usize = 1 << 14;

/// Requests under way that come from one process, or go to it.
pub(super) const CALLS: usize = 1 << 16;

/// Threads that open, close and ask for one proxy at a time. Beyond, it waits.
const WORKERS: usize = 32;

/// One proxy.
pub(super) struct Guest {
    pub(super) middleware: Arc<dyn Middleware>,
    pub(super) gathered: Arc<Gathered>,
    pub(super) mouth: Arc<Mouth>,
    pub(super) orders: OnceLock<Orders<Outgoing<Feed>>>,
    /// `None` when it has gone.
    pub(super) ends: Mutex<Option<HashMap<u32, End>>>,
    /// Requests that its clients made.
    pub(super) called: Mutex<HashMap<u64, Called>>,
    /// Requests to its services, and messages to its daemon.
    pub(super) asked: Mutex<HashMap<u64, Asked>>,
    pub(super) numbers: AtomicU64,
    pub(super) workers: AtomicUsize,
}

impl Guest {
    pub(super) fn with<T>(&self, number: u32, work: impl FnOnce(&mut End) -> T) -> Option<T> {
        lock(&self.ends).as_mut()?.get_mut(&number).map(work)
    }

    /// The end of a client.
    pub(super) fn client(&self, number: u32) -> Option<Calling> {
        let client = |end: &mut End| match end {
            End::Client(client) => Some(Arc::clone(client)),
            _ => None,
        };
        self.with(number, client).flatten()
    }

    /// The line of a subscription.
    pub(super) fn line(&self, number: u32) -> Option<usize> {
        let line = |end: &mut End| match end {
            End::Subscription(line) => Some(*line),
            _ => None,
        };
        self.with(number, line).flatten()
    }

    /// Puts an end that was opened in its place, unless it was closed meanwhile.
    pub(super) fn keep(&self, number: u32, opened: End) -> Result<(), End> {
        let mut ends = lock(&self.ends);
        match ends.as_mut().and_then(|ends| ends.get_mut(&number)) {
            Some(place) => {
                *place = opened;
                Ok(())
            }
            None => Err(opened),
        }
    }

    pub(super) fn forget(&self, number: u32) {
        let gone = lock(&self.ends).as_mut().and_then(|ends| ends.remove(&number));
        drop(gone);
    }

    /// Ends an end that is out of the list.
    pub(super) fn end(&self, end: Option<End>) {
        if let (Some(End::Subscription(line)), Some(orders)) = (&end, self.orders.get()) {
            orders.remove(*line, |_, _| {});
        }
        drop(end);
    }

    /// Looks for losses that the middleware found without a sample that comes or goes; returns
    /// whether there are ports.
    pub(super) fn look_for_losses(&self) -> bool {
        let (mut writers, mut lines) = (Vec::new(), Vec::new());
        for end in lock(&self.ends).iter().flat_map(HashMap::values) {
            match end {
                End::Publisher(writer) => writers.push(Arc::clone(writer)),
                End::Subscription(line) => lines.push(*line),
                _ => {}
            }
        }
        writers.iter().for_each(|writer| lock(writer).tell_lost(&self.mouth));
        if let Some(orders) = self.orders() {
            lines.iter().for_each(|line| orders.mark(*line));
        }
        !writers.is_empty() || !lines.is_empty()
    }

    pub(super) fn orders(&self) -> Option<&Orders<Outgoing<Feed>>> {
        self.orders.get()
    }

    pub(super) fn mouth(&self) -> &Arc<Mouth> {
        &self.mouth
    }

    /// Queues a message.
    pub(super) fn say(&self, down: &Down, payload: &[u8]) {
        self.mouth.say(down, payload);
    }

    /// Does what may take time on a thread of its own.
    pub(super) fn apart(self: &Arc<Self>, work: impl FnOnce(&Arc<Self>) + Send + 'static) {
        let work = Mutex::new(Some(work));
        let guest = Arc::clone(self);
        let free = self.workers.fetch_add(1, Ordering::SeqCst) < WORKERS;
        let work = Arc::new(work);
        let run = {
            let work = Arc::clone(&work);
            move || {
                let taken = lock(&work).take();
                if let Some(work) = taken {
                    work(&guest);
                }
                guest.workers.fetch_sub(1, Ordering::SeqCst);
                drop(guest);
            }
        };
        let name = "gateway-worker".to_owned();
        if !free || thread::Builder::new().name(name).spawn(run).is_err() {
            let taken = lock(&work).take();
            if let Some(work) = taken {
                work(self);
            }
            self.workers.fetch_sub(1, Ordering::SeqCst);
        }
    }
}
