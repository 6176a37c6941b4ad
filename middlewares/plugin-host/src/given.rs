//! What the host gives to a library: where samples, requests and answers go.

use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use genom_kit::complaints::Complaints;
use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;
use genom_middleware::{OnRequest, ServiceHandler, ServiceType};
use genom_plugin_abi::Sides;
use genom_plugin_abi::answers::Waiting;
use genom_types::DataType;

use crate::calls::Relayed;
use crate::library::Library;
use crate::listing::MESSAGE;

/// What was given for one end.
pub(crate) enum Given {
    Inbox(Arc<Inbox>),
    Served(Serving),
    Call(Calling),
    Daemon(Arc<Daemon>),
}

/// Unread samples of an in port.
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox,
    /// A mailbox has one producer at a time; a library may have several.
    fills: Mutex<()>,
    /// Whether overwritten samples are losses; false for policy `latest`.
    counts: bool,
    /// Samples that could not be decoded.
    pub(crate) undecodable: AtomicU64,
    pub(crate) told: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

impl Inbox {
    pub(crate) fn new(keeping: Keeping, room: usize) -> Self {
        Self {
            mailbox: Mailbox::new(keeping.depth, room, keeping.full).dated(),
            fills: Mutex::new(()),
            counts: keeping.counts,
            undecodable: AtomicU64::new(0),
            told: OnceLock::new(),
        }
    }

    pub(crate) fn arrive(&self, sample: &[u8]) {
        let fills = self.fills.lock().unwrap_or_else(PoisonError::into_inner);
        let put = self.mailbox.put(|buffer| {
            buffer.extend_from_slice(sample);
            Ok::<_, Infallible>(())
        });
        drop(fills);
        if put.is_err() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(told) = self.told.get() {
            told();
        }
    }

    /// Samples lost to the reader, as far as it is known here.
    pub(crate) fn lost(&self) -> u64 {
        let overwritten = if self.counts { self.mailbox.lost() } else { 0 };
        overwritten + self.undecodable.load(Ordering::Relaxed)
    }
}

/// A served service.
pub(crate) struct Serving {
    pub(crate) library: &'static Library,
    pub(crate) service: ServiceType,
    pub(crate) handler: Arc<dyn ServiceHandler>,
}

/// A request to a service elsewhere.
pub(crate) struct Calling {
    pub(crate) waiting: Waiting,
    pub(crate) output: DataType,
    pub(crate) sides: Sides,
}

/// Most requests to a daemon that wait for their replies.
const WAITING: usize = 1024;

/// A daemon that others reach.
pub(crate) struct Daemon {
    pub(crate) name: String,
    pub(crate) library: &'static Library,
    pub(crate) requests: Box<OnRequest>,
    /// Set when it is withdrawn; requests that come later are not answered.
    pub(crate) withdrawn: AtomicBool,
    pub(crate) waiting: Arc<AtomicUsize>,
    pub(crate) refused: Complaints,
}

/// One of the requests that wait.
struct Place(Arc<AtomicUsize>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Daemon {
    /// A request arrived. Closed without a reply if it is dropped here.
    pub(crate) fn arrive(&self, relayed: Relayed, request: &[u8]) {
        if self.withdrawn.load(Ordering::Acquire) {
            return;
        }
        let waiting = self.waiting.fetch_add(1, Ordering::Relaxed);
        let place = Place(Arc::clone(&self.waiting));
        let why = if waiting >= WAITING {
            format!("{WAITING} others wait for their replies")
        } else if request.len() > MESSAGE {
            format!("it has {} bytes", request.len())
        } else {
            let answer = move |reply: Vec<u8>| {
                relayed.reply(&reply);
                drop(place);
            };
            return (self.requests)(request.to_vec(), Box::new(answer));
        };
        if let Some(count) = self.refused.add() {
            let (library, name) = (self.library.name(), &self.name);
            tracing::warn!(
                "{library}: a request to daemon {name} is refused: {why} ({count} so far)"
            );
        }
    }
}
