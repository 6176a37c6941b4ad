//! Samples between real-time threads and the threads of the proxy.

use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;
use genom_kit::outlet::Outlet;
use genom_kit::sender;
use genom_kit::spares::Message;

use crate::channel::Channel;

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    end: u32,
    outlet: Arc<Outlet>,
    channel: Arc<Channel>,
    /// Whether a gateway has it open.
    live: Arc<AtomicBool>,
    /// What late readers get.
    last: Option<Message>,
    /// Whether the last value is to be sent once more.
    repeats: bool,
}

impl Line {
    pub(super) fn new(
        end: u32,
        outlet: &Arc<Outlet>,
        channel: &Arc<Channel>,
        live: &Arc<AtomicBool>,
    ) -> Self {
        let (outlet, channel) = (Arc::clone(outlet), Arc::clone(channel));
        Self { end, outlet, channel, live: Arc::clone(live), last: None, repeats: false }
    }

    pub(super) fn repeat(&mut self) {
        self.repeats = true;
    }
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        if !self.live.load(Ordering::SeqCst) {
            return false;
        }
        if std::mem::take(&mut self.repeats) {
            if let Some(last) = &self.last {
                self.channel.sample(self.end, last.as_ref());
            }
            return true;
        }
        let Some(message) = self.outlet.take() else { return false };
        if !self.channel.sample(self.end, message.as_ref()) {
            self.live.store(false, Ordering::SeqCst);
        }
        self.last = Some(message);
        true
    }
}

/// Unread samples of an in port: filled by the hearing thread, emptied by the codel's.
pub(crate) struct Inbox {
    pub(super) mailbox: Mailbox,
    /// Whether overwritten samples are losses; false for policy `latest`.
    counts: bool,
    /// Number of samples that could not be decoded.
    pub(super) undecodable: AtomicU64,
    /// Lost before they arrived here.
    pub(super) lost: Lost,
    pub(super) told: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

impl Inbox {
    pub(super) fn new(keeping: Keeping, room: usize) -> Self {
        Self {
            mailbox: Mailbox::new(keeping.depth, room, keeping.full).dated(),
            counts: keeping.counts,
            undecodable: AtomicU64::new(0),
            lost: Lost::default(),
            told: OnceLock::new(),
        }
    }

    pub(super) fn arrive(&self, message: &[u8]) {
        let put = self.mailbox.put(|buffer| {
            buffer.extend_from_slice(message);
            Ok::<_, Infallible>(())
        });
        if put.is_err() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(told) = self.told.get() {
            told();
        }
    }

    /// Number of samples lost to the reader.
    pub(super) fn lost(&self) -> u64 {
        let overwritten = if self.counts { self.mailbox.lost() } else { 0 };
        overwritten + self.undecodable.load(Ordering::Relaxed) + self.lost.count()
    }
}

/// Samples that were lost behind this process, in all gateways so far.
#[derive(Debug, Default)]
pub(crate) struct Lost {
    before: AtomicU64,
    now: AtomicU64,
}

impl Lost {
    pub(crate) fn count(&self) -> u64 {
        self.before.load(Ordering::Relaxed) + self.now.load(Ordering::Relaxed)
    }

    pub(crate) fn set(&self, count: u64) {
        self.now.store(count, Ordering::Relaxed);
    }

    /// The gateway that counted has ended.
    pub(crate) fn settle(&self) {
        self.before.fetch_add(self.now.swap(0, Ordering::Relaxed), Ordering::Relaxed);
    }
}
