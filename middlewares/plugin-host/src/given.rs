//! What the host gives to a library: where samples, requests and answers go.

use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;
use genom_middleware::{Endpoint, Refused, ServiceHandler, ServiceType};
use genom_plugin_abi::Sides;
use genom_plugin_abi::answers::Waiting;
use genom_types::DataType;

use crate::library::Library;

/// What was given for one end.
pub(crate) enum Given {
    Inbox(Arc<Inbox>),
    Served(Serving),
    Call(Calling),
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

/// What a library lists during a call.
#[derive(Default)]
pub(crate) struct Listing(Mutex<Listed>);

#[derive(Default)]
pub(crate) struct Listed {
    pub(crate) endpoints: Vec<Endpoint>,
    pub(crate) texts: Vec<(String, String)>,
    pub(crate) refused: Vec<Refused>,
}

impl Listing {
    pub(crate) fn add(&self, with: impl FnOnce(&mut Listed)) {
        with(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }

    pub(crate) fn into_listed(self) -> Listed {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}
