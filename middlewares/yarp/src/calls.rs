//! The thread on which services hear their requests, so that a slow one delays no sample.

use std::cell::Cell;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Greatest number of requests that wait.
const MOST: usize = 1024;

thread_local! {
    static HERE: Cell<bool> = const { Cell::new(false) };
}

/// Serves requests.
pub(crate) trait Serve: Send + Sync {
    /// Serves a request. `token` is the connection, which waits if it `replies`.
    fn hear(self: Arc<Self>, token: u64, replies: bool, request: &[u8]);
}

/// A request.
struct Call {
    desk: Arc<dyn Serve>,
    token: u64,
    replies: bool,
    bottle: Vec<u8>,
}

/// Passes requests to the thread.
pub(crate) struct Calls(SyncSender<Option<Call>>);

impl Calls {
    pub(crate) fn start() -> io::Result<(Arc<Self>, JoinHandle<()>)> {
        let (submit, requests) = sync_channel(MOST);
        let thread = std::thread::Builder::new().name("yarp-calls".to_owned());
        let thread = thread.spawn(move || serve(&requests))?;
        Ok((Arc::new(Self(submit)), thread))
    }

    /// Passes a request on. Returns false if too many wait.
    pub(crate) fn hear(
        &self,
        desk: Arc<dyn Serve>,
        token: u64,
        replies: bool,
        bottle: Vec<u8>,
    ) -> bool {
        self.0.try_send(Some(Call { desk, token, replies, bottle })).is_ok()
    }

    /// Ends the thread once what waits is done.
    pub(crate) fn end(&self) {
        let _ = self.0.send(None);
    }

    /// Whether the calling thread is this one.
    pub(crate) fn is_here() -> bool {
        HERE.get()
    }
}

fn serve(requests: &Receiver<Option<Call>>) {
    HERE.set(true);
    while let Ok(Some(Call { desk, token, replies, bottle })) = requests.recv() {
        desk.hear(token, replies, &bottle);
    }
}
