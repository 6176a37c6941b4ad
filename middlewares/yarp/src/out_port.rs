//! The connections of an out port, and the samples on their way to them.
//!
//! Nothing here waits: what a connection does not take now is kept for it, and when that is too
//! much its oldest samples are dropped and counted. So a reader that stopped holds nobody up.

use std::collections::VecDeque;
use std::io::{ErrorKind, Write as _};
use std::net::TcpStream;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_types::DataType;
use rustix::event::epoll;

use crate::wire::Carrier;

/// Greatest number of readers of an out port.
pub(crate) const MOST_LINKS: usize = 64;

/// A message as it is sent, shared by all connections.
pub(crate) type Frame = Arc<Vec<u8>>;

/// The sending side of an out port.
pub(crate) struct OutPort {
    pub(crate) ty: DataType,
    /// Greatest number of unsent samples of a connection.
    depth: usize,
    state: Mutex<State>,
    dropped: AtomicU64,
}

#[derive(Default)]
struct State {
    links: Vec<Link>,
    /// For readers that connect later.
    last: Option<Frame>,
}

/// A connection to a reader.
pub(crate) struct Link {
    /// Its number in the thread of connections.
    pub(crate) token: u64,
    /// Name of the reader's port.
    pub(crate) to: String,
    pub(crate) carrier: Carrier,
    pub(crate) stream: Arc<TcpStream>,
    pub(crate) epoll: Arc<OwnedFd>,
    queue: VecDeque<Frame>,
    /// Bytes of the first one that were sent.
    sent: usize,
    /// Whether the acknowledgement of the last one is due.
    unacknowledged: bool,
    /// Whether the thread of connections is told when there is room again.
    armed: bool,
}

impl Link {
    pub(crate) fn new(
        (token, to, carrier): (u64, String, Carrier),
        stream: Arc<TcpStream>,
        epoll: Arc<OwnedFd>,
    ) -> Self {
        let queue = VecDeque::new();
        Self {
            token,
            to,
            carrier,
            stream,
            epoll,
            queue,
            sent: 0,
            unacknowledged: false,
            armed: false,
        }
    }

    /// Keeps a sample for sending. Returns how many were dropped for it.
    fn push(&mut self, frame: Frame, depth: usize) -> u64 {
        self.queue.push_back(frame);
        let mut dropped = 0;
        while self.queue.len() > depth.max(1) + usize::from(self.sent > 0) {
            // One that was begun has to be sent to its end.
            self.queue.remove(usize::from(self.sent > 0));
            dropped += 1;
        }
        dropped
    }

    /// Sends what the connection takes. Errors show in the thread of connections, too.
    fn flush(&mut self) {
        let mut blocked = false;
        while let Some(frame) = self.queue.front() {
            if self.sent == 0 && self.unacknowledged {
                break;
            }
            match (&*self.stream).write(frame.get(self.sent..).unwrap_or_default()) {
                Ok(size) => self.sent += size,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => {
                    blocked = error.kind() == ErrorKind::WouldBlock;
                    if !blocked {
                        self.queue.clear();
                        self.sent = 0;
                    }
                    break;
                }
            }
            if self.sent >= frame.len() {
                self.queue.pop_front();
                self.sent = 0;
                self.unacknowledged = self.carrier.acknowledges();
            }
        }
        if blocked != self.armed {
            self.armed = blocked;
            let out = if blocked { epoll::EventFlags::OUT } else { epoll::EventFlags::empty() };
            let data = epoll::EventData::new_u64(self.token);
            let flags = epoll::EventFlags::IN | out;
            // Fails when the connection was closed meanwhile.
            let _ = epoll::modify(&self.epoll, &self.stream, data, flags);
        }
    }

    fn is_done(&self) -> bool {
        self.queue.is_empty() && !self.unacknowledged
    }
}

impl OutPort {
    pub(crate) fn new(ty: &DataType, depth: usize) -> Self {
        let (ty, state) = (ty.clone(), Mutex::default());
        Self { ty, depth, state, dropped: AtomicU64::new(0) }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a sample to all readers. For the sending thread.
    pub(crate) fn send(&self, frame: Frame) {
        let mut state = self.lock();
        let mut dropped = 0;
        for link in &mut state.links {
            dropped += link.push(Arc::clone(&frame), self.depth);
            link.flush();
        }
        state.last = Some(frame);
        drop(state);
        self.dropped.fetch_add(dropped, Ordering::Relaxed);
    }

    /// Samples that connections did not take in time.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Adds a reader, which gets the last sample. One of the same name is replaced; its number is
    /// returned.
    pub(crate) fn join(&self, mut link: Link) -> Option<u64> {
        let mut state = self.lock();
        if let Some(last) = &state.last {
            link.push(Arc::clone(last), self.depth);
            link.flush();
        }
        let former = state.links.iter().position(|other| other.to == link.to);
        let former = former.map(|index| state.links.swap_remove(index).token);
        state.links.push(link);
        former
    }

    /// Removes a reader.
    pub(crate) fn leave(&self, token: u64) -> Option<String> {
        let mut state = self.lock();
        let index = state.links.iter().position(|link| link.token == token)?;
        Some(state.links.swap_remove(index).to)
    }

    /// Number of the connection to a reader.
    pub(crate) fn link_to(&self, to: &str) -> Option<u64> {
        self.lock().links.iter().find(|link| link.to == to).map(|link| link.token)
    }

    /// The readers, with their carriers.
    pub(crate) fn links(&self) -> Vec<(String, Carrier)> {
        self.lock().links.iter().map(|link| (link.to.clone(), link.carrier)).collect()
    }

    /// There is room in a connection again, or it acknowledged.
    pub(crate) fn go_on(&self, token: u64, acknowledged: bool) {
        if let Some(link) = self.lock().links.iter_mut().find(|link| link.token == token) {
            link.unacknowledged &= !acknowledged;
            link.flush();
        }
    }

    /// Whether a connection has nothing more to send.
    pub(crate) fn is_done(&self, token: u64) -> bool {
        self.lock().links.iter().find(|link| link.token == token).is_none_or(Link::is_done)
    }
}
