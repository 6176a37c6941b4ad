//! Announcements that make this daemon visible on middlewares.

use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use genom_doors::Desk;
use genom_middleware::{AnnounceError, Middleware};
use tokio::runtime::Handle;

/// Announcements, each with a name. Dropping the value withdraws the announcement.
#[derive(Default)]
pub(crate) struct Announcements(Mutex<Vec<(String, Box<dyn Send + Sync>)>>);

impl Announcements {
    /// Announces this daemon on a middleware that relays requests, under the first of these names
    /// that no other daemon uses there. `open` creates the desk that handles messages to that name.
    pub(crate) fn announce(
        &self,
        names: &[String],
        on: &dyn Middleware,
        open: impl Fn(&str) -> io::Result<Arc<Desk>>,
        runtime: &Handle,
    ) {
        let Some(relay) = on.relay() else { return };
        let mut refused = None;
        for name in names {
            let desk = match open(name) {
                Ok(desk) => desk,
                Err(error) => return tracing::warn!("this daemon is not reachable there: {error}"),
            };
            let runtime = runtime.clone();
            let take = move |bytes: Vec<u8>, answer: Box<dyn FnOnce(Vec<u8>) + Send>| {
                desk.take(&runtime, bytes, answer);
            };
            match relay.announce(name, Box::new(take)) {
                Ok(announcement) => {
                    if let Some(error) = refused {
                        tracing::warn!("{error}; this one is `{name}` there");
                    }
                    return self.keep(name.clone(), announcement);
                }
                // Another daemon has that name: try the next one, which no other daemon uses.
                Err(error @ AnnounceError::Taken { .. }) => refused = Some(error),
                Err(error) => return tracing::warn!("{error}"),
            }
        }
        if let Some(error) = refused {
            tracing::warn!("{error}; this one is not reachable there");
        }
    }

    fn keep(&self, name: String, announcement: Box<dyn Send + Sync>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((name, announcement));
    }

    /// The name under which others see the daemon; `None` if it is not announced.
    pub(crate) fn name(&self) -> Option<String> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.first().map(|(name, _)| name.clone())
    }

    /// Withdraws all announcements.
    pub(crate) fn withdraw(&self) {
        let all = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        drop(all);
    }
}

/// Possible names of this daemon, the preferred one first: the one it was started with, else one
/// derived from the machine's.
pub(crate) fn names(given: Option<&str>) -> Vec<String> {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = given.unwrap_or_else(|| host.trim());
    let name = if name.is_empty() { "genomd" } else { name };
    vec![name.to_owned(), format!("{name}-{}", std::process::id())]
}
