//! A proxy, and what its ends hold on to.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use genom_kit::sender::Sender;

use super::book::Shared;
use super::lines::Line;
use super::link;
use crate::channel::{Outgoing, lock};
use crate::place::Reach;

/// How long the daemon may take until there is a gateway.
const PATIENCE: Duration = Duration::from_secs(70);

/// How long it may take to find somebody who starts one, on a machine that is busy.
const NOBODY: Duration = Duration::from_secs(20);

/// A middleware that a gateway has opened.
#[derive(Clone)]
pub struct Proxy {
    pub(crate) core: Arc<Core>,
}

/// There is no gateway.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Closed(String);

/// What all ends share. Fields are dropped in order.
pub(crate) struct Core {
    pub(crate) shared: Arc<Shared>,
    sender: Option<Sender<Outgoing<Line>>>,
    hearing: Option<JoinHandle<()>>,
}

impl Drop for Core {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        // What was queued last, such as the end of a service, gets through before the end.
        self.sender = None;
        self.shared.hang_up();
        if let Some(hearing) = self.hearing.take()
            && hearing.thread().id() != thread::current().id()
        {
            hearing.thread().unpark();
            // A panic of the thread has been reported already.
            let _ = hearing.join();
        }
    }
}

impl Proxy {
    /// Reaches the gateway of the middleware of this name, which the daemon starts if there is
    /// none.
    ///
    /// # Errors
    /// The middleware cannot be opened there, or nobody starts a gateway.
    pub fn open(name: &'static str, reach: Reach) -> Result<Self, Closed> {
        let failed = |error: std::io::Error| Closed(error.to_string());
        let shared = Arc::new(Shared::new(name, reach));
        let due = Arc::clone(&shared);
        let duty = Outgoing::new(&shared.channel, move || due.open_again());
        let sender = Sender::single(&format!("{name}-proxy"), true, duty).map_err(failed)?;
        let _ = shared.orders.set(sender.orders().clone());
        let worker = Arc::clone(&shared);
        let hearing = thread::Builder::new()
            .name(format!("{name}-proxy"))
            .spawn(move || link::keep_up(&worker))
            .map_err(failed)?;
        let core = Core { shared, sender: Some(sender), hearing: Some(hearing) };
        let proxy = Self { core: Arc::new(core) };
        proxy.wait()?;
        Ok(proxy)
    }

    /// Waits until the gateway answers for the first time.
    fn wait(&self) -> Result<(), Closed> {
        let shared = &self.core.shared;
        let begin = Instant::now();
        let mut book = lock(&shared.book);
        loop {
            if book.up {
                return Ok(());
            }
            let limit = match (book.refused, shared.waits_for_daemon()) {
                (true, _) => Duration::ZERO,
                (false, true) => PATIENCE,
                (false, false) => NOBODY,
            };
            if begin.elapsed() >= limit {
                let why = book.why.clone();
                let why = why.unwrap_or_else(|| "the daemon starts no gateway in time".into());
                return Err(Closed(why));
            }
            let pause = Duration::from_millis(50);
            let waited = shared.changed.wait_timeout(book, pause);
            book = waited.unwrap_or_else(std::sync::PoisonError::into_inner).0;
        }
    }

    pub(crate) fn shared(&self) -> &Arc<Shared> {
        &self.core.shared
    }
}

/// An open end, until it is dropped.
pub(crate) struct Held {
    pub(crate) end: u32,
    pub(crate) core: Arc<Core>,
}

impl Drop for Held {
    fn drop(&mut self) {
        self.core.shared.close(self.end);
    }
}
