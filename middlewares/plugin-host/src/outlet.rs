//! Samples between a codel and the thread that gives them to the library.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use genom_kit::mailbox::{Full, Mailbox};
use genom_kit::sender;
use genom_kit::spares::Spares;
use genom_plugin_abi::Code;

use crate::calls::Handle;
use crate::form::Form;

/// Samples on their way from a codel to the sending thread.
pub(crate) struct Outlet {
    pub(crate) form: Form,
    pub(crate) mailbox: Mailbox,
    spares: Spares,
    pub(crate) refused: AtomicU64,
}

impl Outlet {
    pub(crate) fn new(form: Form, depth: usize) -> Self {
        let room = form.room();
        let (mailbox, spares) = (Mailbox::new(depth, room, Full::Oldest), Spares::new(room));
        Self { form, mailbox, spares, refused: AtomicU64::new(0) }
    }
}

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    pub(crate) outlet: Arc<Outlet>,
    pub(crate) handle: Arc<Handle>,
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let Some(sample) = self.outlet.spares.take(&self.outlet.mailbox) else { return false };
        if self.handle.publish(sample.as_ref()) != Code::OK {
            self.outlet.refused.fetch_add(1, Ordering::Relaxed);
        }
        true
    }
}
