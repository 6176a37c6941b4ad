//! What the host gave: its functions, and what it wants to be told through them.

use std::sync::Arc;

use genom_plugin_abi::table::Opaque;
use genom_plugin_abi::{Bytes, Host, Str};

/// The functions of the host.
#[derive(Clone, Copy)]
pub(crate) struct Functions(Host);

// SAFETY: the functions may be called from any thread, and so may `log` with the pointer for it.
unsafe impl Send for Functions {}
// SAFETY: as above.
unsafe impl Sync for Functions {}

impl Functions {
    /// # Safety
    /// The table is one that a host gave.
    pub(crate) unsafe fn of(host: *const Host) -> Option<Self> {
        // SAFETY: a host's table begins with its size; zero is a value of all its members.
        unsafe { genom_plugin_abi::lent::copied(host) }.map(Self)
    }

    /// A line for the log.
    pub(crate) fn log(&self, level: u32, text: &str) {
        if let Some(log) = self.0.log {
            // SAFETY: the pointer is the host's own for this; the text is lent for the call.
            unsafe { log(self.0.host, level, Str::of(text)) };
        }
    }

    /// Takes over what was given for an end; it is released when the last clone is dropped.
    ///
    /// # Safety
    /// The host gave it, and nobody else releases it.
    pub(crate) unsafe fn take(self, to: Opaque) -> Arc<Given> {
        Arc::new(Given { functions: self, to })
    }

    /// A list that the host lent.
    pub(crate) fn list(self, list: Opaque) -> List {
        List { functions: self, list }
    }
}

/// What was given for an end. Released when dropped.
pub(crate) struct Given {
    functions: Functions,
    to: Opaque,
}

// SAFETY: what is given may be used from any thread.
unsafe impl Send for Given {}
// SAFETY: as above.
unsafe impl Sync for Given {}

impl Given {
    pub(crate) fn sample(&self, message: &[u8]) {
        if let Some(sample) = self.functions.0.sample {
            // SAFETY: it was not released; the bytes are lent for the call.
            unsafe { sample(self.to, Bytes::of(message)) };
        }
    }

    pub(crate) fn request(&self, call: Opaque, input: &[u8]) -> bool {
        let Some(request) = self.functions.0.request else { return false };
        // SAFETY: as for samples.
        unsafe { request(self.to, call, Bytes::of(input)) };
        true
    }

    /// Whether requests for a daemon can be passed on.
    pub(crate) fn relays(&self) -> bool {
        self.functions.0.relayed.is_some()
    }

    pub(crate) fn relayed(&self, request: Opaque, message: &[u8]) -> bool {
        let Some(relayed) = self.functions.0.relayed else { return false };
        // SAFETY: as for samples.
        unsafe { relayed(self.to, request, Bytes::of(message)) };
        true
    }

    pub(crate) fn cancel(&self, run: u64) {
        if let Some(cancel) = self.functions.0.cancel {
            // SAFETY: as for samples.
            unsafe { cancel(self.to, run) };
        }
    }

    pub(crate) fn answer(&self, answer: &genom_plugin_abi::Answer) {
        if let Some(tell) = self.functions.0.answer {
            // SAFETY: as for samples.
            unsafe { tell(self.to, answer) };
        }
    }
}

impl Drop for Given {
    fn drop(&mut self) {
        if let Some(release) = self.functions.0.release {
            // SAFETY: this is the only release, and nothing uses it from now on.
            unsafe { release(self.to) };
        }
    }
}

/// A list of the host, for the time of a call.
pub(crate) struct List {
    functions: Functions,
    list: Opaque,
}

impl List {
    pub(crate) fn endpoint(&self, kind: u32, address: &str, ty: &str) {
        if let Some(add) = self.functions.0.endpoint {
            // SAFETY: the list is lent for the call that this is part of; so are the texts.
            unsafe { add(self.list, kind, Str::of(address), Str::of(ty)) };
        }
    }

    pub(crate) fn text(&self, key: &str, value: &str) {
        if let Some(add) = self.functions.0.text {
            // SAFETY: as above.
            unsafe { add(self.list, Str::of(key), Str::of(value)) };
        }
    }

    pub(crate) fn refusal(&self, why: &str, count: u64, peer: &str) {
        if let Some(add) = self.functions.0.refusal {
            // SAFETY: as above.
            unsafe { add(self.list, Str::of(why), count, Str::of(peer)) };
        }
    }

    pub(crate) fn reply(&self, from: &str, reply: &[u8]) {
        if let Some(add) = self.functions.0.replied {
            // SAFETY: as above.
            unsafe { add(self.list, Str::of(from), Bytes::of(reply)) };
        }
    }
}
