//! The receiving side of an in port: bottles become samples in the mailboxes of its readers.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use genom_kit::mailbox::Mailbox;
use genom_types::DataType;

use crate::bottle::decode;
use crate::refusals::Refusals;

/// Samples that one reader has not read yet.
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox,
    /// Samples that were no value of the type.
    pub(crate) misfits: AtomicU64,
    told: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

impl Inbox {
    pub(crate) fn new(mailbox: Mailbox) -> Self {
        Self { mailbox, misfits: AtomicU64::new(0), told: OnceLock::new() }
    }

    /// Calls `told` for each sample from now on. Returns false if another is called already.
    pub(crate) fn tell(&self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.told.set(told).is_ok()
    }

    fn put(&self, sample: &[u8]) {
        let copy = |buffer: &mut Vec<u8>| {
            buffer.extend_from_slice(sample);
            Ok::<_, ()>(())
        };
        // The mailbox counts samples for which it has no space.
        let _ = self.mailbox.put(copy);
    }
}

/// An in port: all readers of one out port in this process share it.
pub(crate) struct InPort {
    pub(crate) ty: DataType,
    /// Name of the out port.
    pub(crate) source: String,
    /// Whether the out port is being asked to connect.
    pub(crate) asking: Arc<AtomicBool>,
    /// Why it refused last, which is logged once.
    pub(crate) refusal: Arc<Mutex<String>>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Replaced as a whole, so that they can be told without the lock.
    readers: Arc<Vec<Arc<Inbox>>>,
    /// Names of those who are connected, by the numbers of their connections.
    senders: HashMap<u64, String>,
    /// The last sample in CDR, and the connection that it came from: a reader that comes later
    /// gets it while its writer is there.
    last: Vec<u8>,
    last_from: Option<u64>,
}

impl InPort {
    pub(crate) fn new(ty: &DataType, source: String) -> Self {
        Self {
            ty: ty.clone(),
            source,
            asking: Arc::default(),
            refusal: Arc::default(),
            state: Mutex::default(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a reader, which gets the last sample.
    pub(crate) fn join(&self, inbox: &Arc<Inbox>) {
        let mut state = self.lock();
        if state.last_from.is_some() {
            inbox.put(&state.last);
        }
        Arc::make_mut(&mut state.readers).push(Arc::clone(inbox));
    }

    pub(crate) fn leave(&self, inbox: &Arc<Inbox>) {
        Arc::make_mut(&mut self.lock().readers).retain(|other| !Arc::ptr_eq(other, inbox));
    }

    /// A writer has connected.
    pub(crate) fn connected(&self, token: u64, name: &str) {
        self.lock().senders.insert(token, name.to_owned());
    }

    /// A writer has gone. Returns its name.
    pub(crate) fn gone(&self, token: u64) -> Option<String> {
        let mut state = self.lock();
        state.last_from = state.last_from.filter(|from| *from != token);
        state.senders.remove(&token)
    }

    /// Names of those who are connected, with the numbers of their connections.
    pub(crate) fn senders(&self) -> Vec<(u64, String)> {
        self.lock().senders.iter().map(|(token, name)| (*token, name.clone())).collect()
    }

    /// Whether the out port that is read is connected.
    pub(crate) fn is_connected(&self) -> bool {
        self.lock().senders.values().any(|name| *name == self.source)
    }

    /// Takes a bottle.
    pub(crate) fn take(&self, token: u64, bottle: &[u8], peer: IpAddr, refusals: &Refusals) {
        let mut state = self.lock();
        let State { readers, last, last_from, senders } = &mut *state;
        match decode::message(&self.ty, bottle, last) {
            Ok(()) => {
                *last_from = Some(token);
                readers.iter().for_each(|reader| reader.put(last));
                let readers = Arc::clone(readers);
                // Those who are told may close what they read.
                drop(state);
                readers.iter().filter_map(|reader| reader.told.get()).for_each(|told| told());
            }
            Err(misfit) => {
                *last_from = None;
                for reader in readers.iter() {
                    reader.misfits.fetch_add(1, Ordering::Relaxed);
                }
                let from = senders.get(&token).cloned().unwrap_or_default();
                let detail = format!("from {from} for {}: {misfit}", self.ty.name());
                drop(state);
                refusals.add("a bottle that is no sample of its port's type", Some(peer), &detail);
            }
        }
    }
}
