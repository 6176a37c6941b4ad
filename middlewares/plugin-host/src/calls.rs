//! Calls of a library's functions, and handles that are closed when they are dropped.

#![allow(unsafe_code, reason = "it calls functions of a library")]

use std::ptr;

use genom_plugin_abi::answers::Said;
use genom_plugin_abi::table::{Address, Opaque};
use genom_plugin_abi::{Bytes, Code, Diagnosis, Entry, ErrorText, Failure, Port, Service, Str};

use crate::error::LibraryError;
use crate::library::Library;

/// Bytes for the text of an error.
const TEXT: usize = 1024;

type Close = Option<unsafe extern "C" fn(Opaque)>;

/// Something that a library opened. Closed when dropped.
pub(crate) struct Handle {
    library: &'static Library,
    handle: Opaque,
    close: Close,
}

// SAFETY: a handle may be used in any thread, one at a time.
unsafe impl Send for Handle {}
// SAFETY: through a shared handle only functions are called that may be called at any time, or that
// its owner calls from one thread at a time: see `publish` and `request`.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        if let Some(close) = self.close {
            // SAFETY: the library opened it, and this is its only close.
            unsafe { close(self.handle) };
        }
    }
}

/// Calls a function that can fail.
fn tried(call: impl FnOnce(*mut Opaque, *mut ErrorText) -> Code) -> Result<Opaque, Failure> {
    let mut buffer = [0; TEXT];
    let mut error = ErrorText::new(&mut buffer);
    let mut made = ptr::null_mut();
    let code = call(&raw mut made, &raw mut error);
    // SAFETY: its buffer is still there.
    match unsafe { error.read(code) } {
        None => Ok(made),
        Some(failure) => Err(failure),
    }
}

fn missing() -> Failure {
    Failure::new(Code::FAILED, "its table has no such function")
}

impl Library {
    fn handle(&'static self, handle: Opaque, close: Close) -> Handle {
        Handle { library: self, handle, close }
    }

    pub(crate) fn open_backend(&'static self, options: &str) -> Result<Handle, LibraryError> {
        let refused = |failure: Failure| LibraryError::Refused { why: failure.why() };
        let open = self.table.open.ok_or_else(missing).map_err(refused)?;
        // SAFETY: the functions of the host live as long as the library; the rest is lent.
        let made = tried(|out, error| unsafe { open(&self.host, Str::of(options), out, error) });
        Ok(self.handle(made.map_err(refused)?, self.table.close))
    }
}

/// The functions of an open backend.
impl Handle {
    pub(crate) fn capabilities(&self) -> u64 {
        let table = &self.library.table;
        // SAFETY: an open backend.
        table.capabilities_of.map_or(table.capabilities, |of| unsafe { of(self.handle) })
    }

    pub(crate) fn publisher(&self, port: *const Port) -> Result<Self, Failure> {
        let publisher = self.library.table.publisher.ok_or_else(missing)?;
        // SAFETY: an open backend; the rest is lent.
        let made = tried(|out, error| unsafe { publisher(self.handle, port, out, error) })?;
        Ok(self.library.handle(made, self.library.table.close_publisher))
    }

    pub(crate) fn subscription(&self, port: *const Port, to: Opaque) -> Result<Self, Failure> {
        let subscription = self.library.table.subscription.ok_or_else(missing)?;
        // SAFETY: an open backend; the library releases what is given, the rest is lent.
        let made = tried(|out, error| unsafe { subscription(self.handle, port, to, out, error) })?;
        Ok(self.library.handle(made, self.library.table.close_subscription))
    }

    pub(crate) fn serve(
        &self,
        at: Address,
        service: *const Service,
        to: Opaque,
    ) -> Result<Self, Failure> {
        let serve = self.library.table.serve.ok_or_else(missing)?;
        // SAFETY: as for a subscription.
        let made = tried(|out, error| unsafe { serve(self.handle, at, service, to, out, error) })?;
        Ok(self.library.handle(made, self.library.table.close_served))
    }

    pub(crate) fn client(&self, at: Address, service: *const Service) -> Result<Self, Failure> {
        let client = self.library.table.client.ok_or_else(missing)?;
        // SAFETY: an open backend; the rest is lent.
        let made = tried(|out, error| unsafe { client(self.handle, at, service, out, error) })?;
        Ok(self.library.handle(made, self.library.table.close_client))
    }

    pub(crate) fn discover(&self, list: Opaque) -> Result<(), Failure> {
        let discover = self.library.table.discover.ok_or_else(missing)?;
        // SAFETY: an open backend, and a list that is lent.
        tried(|_, error| unsafe { discover(self.handle, list, error) }).map(|_| ())
    }

    /// `None` if the library does not list single addresses.
    pub(crate) fn ends_at(&self, at: Address, list: Opaque) -> Option<Result<(), Failure>> {
        let ends_at = self.library.table.ends_at?;
        // SAFETY: an open backend; the rest is lent.
        let done = tried(|_, error| unsafe { ends_at(self.handle, at, list, error) });
        Some(done.map(|_| ()))
    }

    pub(crate) fn spelled(&self, at: Address, list: Opaque) {
        if let Some(spelled) = self.library.table.spelled {
            // SAFETY: an open backend; the rest is lent.
            unsafe { spelled(self.handle, at, list) };
        }
    }

    pub(crate) fn strangers(&self, list: Opaque) {
        if let Some(strangers) = self.library.table.strangers {
            // SAFETY: an open backend, and a list that is lent.
            unsafe { strangers(self.handle, list) };
        }
    }

    pub(crate) fn obstacles(&self, at: Address, list: Opaque) {
        if let Some(obstacles) = self.library.table.obstacles {
            // SAFETY: an open backend; the rest is lent.
            unsafe { obstacles(self.handle, at, list) };
        }
    }

    /// `None` if the middleware has no types of its own.
    pub(crate) fn masquerade(&self, ours: &str, foreign: &str) -> Option<Failure> {
        let masquerade = self.library.table.masquerade?;
        let (ours, foreign) = (Str::of(ours), Str::of(foreign));
        // SAFETY: an open backend; the rest is lent.
        tried(|_, error| unsafe { masquerade(self.handle, ours, foreign, error) }).err()
    }

    pub(crate) fn unmask(&self, ours: &str) {
        if let Some(unmask) = self.library.table.unmask {
            // SAFETY: an open backend, and a string that is lent.
            unsafe { unmask(self.handle, Str::of(ours)) };
        }
    }

    pub(crate) fn meeting_point(&self, list: Opaque) {
        if let Some(meeting_point) = self.library.table.meeting_point {
            // SAFETY: an open backend, and a list that is lent.
            unsafe { meeting_point(self.handle, list) };
        }
    }

    pub(crate) fn refused(&self, list: Opaque) {
        if let Some(refused) = self.library.table.refused {
            // SAFETY: an open backend, and a list that is lent.
            unsafe { refused(self.handle, list) };
        }
    }

    pub(crate) fn trouble(&self, list: Opaque) {
        if let Some(trouble) = self.library.table.trouble {
            // SAFETY: an open backend, and a list that is lent.
            unsafe { trouble(self.handle, list) };
        }
    }
}

/// The functions of an open backend for requests between daemons, and for reports.
impl Handle {
    pub(crate) fn announce(&self, name: &str, to: Opaque) -> Result<Self, Failure> {
        let announce = self.library.table.announce.ok_or_else(missing)?;
        let name = Str::of(name);
        // SAFETY: as for a subscription.
        let made = tried(|out, error| unsafe { announce(self.handle, name, to, out, error) })?;
        Ok(self.library.handle(made, self.library.table.close_announced))
    }

    pub(crate) fn daemons(&self, list: Opaque) -> Result<(), Failure> {
        let daemons = self.library.table.daemons.ok_or_else(missing)?;
        // SAFETY: an open backend, and a list that is lent.
        tried(|_, error| unsafe { daemons(self.handle, list, error) }).map(|_| ())
    }

    pub(crate) fn own(&self, list: Opaque) {
        if let Some(own) = self.library.table.own {
            // SAFETY: an open backend, and a list that is lent.
            unsafe { own(self.handle, list) };
        }
    }

    pub(crate) fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: u64,
        list: Opaque,
    ) -> Result<(), Failure> {
        let ask_all = self.library.table.ask_all.ok_or_else(missing)?;
        let (name, request) = (Str::of(name), Bytes::of(request));
        // SAFETY: an open backend; the rest is lent.
        let ask = |error| unsafe { ask_all(self.handle, name, request, patience, list, error) };
        tried(|_, error| ask(error)).map(|_| ())
    }

    pub(crate) fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: u64,
        list: Opaque,
    ) -> Result<(), Failure> {
        let ask = self.library.table.ask.ok_or_else(missing)?;
        let (name, at, request) = (Str::of(name), Str::of(at), Bytes::of(request));
        // SAFETY: an open backend; the rest is lent.
        let ask = |error| unsafe { ask(self.handle, name, at, request, patience, list, error) };
        tried(|_, error| ask(error)).map(|_| ())
    }

    /// Passes on an entry of a log. One thread makes this call and the next one.
    pub(crate) fn log(&self, entry: &Entry) {
        if let Some(log) = self.library.table.log {
            // SAFETY: an open backend, and an entry that is lent.
            unsafe { log(self.handle, entry) };
        }
    }

    pub(crate) fn diagnose(&self, parts: &[*const Diagnosis]) {
        if let Some(diagnose) = self.library.table.diagnose {
            // SAFETY: an open backend, and diagnoses that are lent.
            unsafe { diagnose(self.handle, parts.as_ptr(), parts.len()) };
        }
    }

    pub(crate) fn simulated_time(&self) {
        if let Some(simulated_time) = self.library.table.simulated_time {
            // SAFETY: an open backend.
            unsafe { simulated_time(self.handle) };
        }
    }
}

/// The functions of an end.
impl Handle {
    /// Publishes a sample. Whoever owns the publisher calls this from one thread at a time.
    pub(crate) fn publish(&self, sample: &[u8]) -> Code {
        let Some(publish) = self.library.table.publish else { return Code::FAILED };
        // SAFETY: an open publisher, and bytes that are lent.
        unsafe { publish(self.handle, Bytes::of(sample)) }
    }

    pub(crate) fn lost_by_publisher(&self) -> u64 {
        // SAFETY: an open publisher; may be called at any time.
        self.library.table.lost_by_publisher.map_or(0, |lost| unsafe { lost(self.handle) })
    }

    pub(crate) fn lost_by_subscription(&self) -> u64 {
        // SAFETY: an open subscription; may be called at any time.
        self.library.table.lost_by_subscription.map_or(0, |lost| unsafe { lost(self.handle) })
    }

    /// Makes a request; `None` for one that cannot be cancelled. Whoever owns the client calls this
    /// from one thread at a time.
    pub(crate) fn request(&self, input: &[u8], to: Opaque) -> Result<Option<Self>, Failure> {
        let request = self.library.table.request.ok_or_else(missing)?;
        // SAFETY: an open client; the library releases what is given, the bytes are lent.
        let run =
            tried(|out, error| unsafe { request(self.handle, Bytes::of(input), to, out, error) })?;
        let run = (!run.is_null()).then_some(run);
        Ok(run.map(|run| self.library.handle(run, self.library.table.close_run)))
    }

    /// Cancels a request that was made.
    pub(crate) fn cancel(&self) {
        if let Some(cancel) = self.library.table.cancel {
            // SAFETY: a request that is not closed.
            unsafe { cancel(self.handle) };
        }
    }
}

/// A request that the library passed on. Closed when dropped.
pub(crate) struct Call(Handle);

impl Call {
    pub(crate) fn new(library: &'static Library, call: Opaque) -> Self {
        Self(library.handle(call, library.table.close_call))
    }

    pub(crate) fn reply(&self, said: Said) {
        if let Some(reply) = self.0.library.table.reply {
            // SAFETY: a request that is not closed, and an answer that is lent.
            said.lend(|answer| unsafe { reply(self.0.handle, answer) });
        }
    }
}

/// A request to a daemon that the library passed on. Closed when dropped.
pub(crate) struct Relayed(Handle);

impl Relayed {
    pub(crate) fn new(library: &'static Library, relayed: Opaque) -> Self {
        Self(library.handle(relayed, library.table.close_relayed))
    }

    /// Replies to it, at most once.
    pub(crate) fn reply(self, reply: &[u8]) {
        if let Some(answer) = self.0.library.table.reply_relayed {
            // SAFETY: a request that is not closed, and bytes that are lent.
            unsafe { answer(self.0.handle, Bytes::of(reply)) };
        }
    }
}
