//! What the thread of connections is asked to do, and who asks.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rustix::event::{EventfdFlags, epoll, eventfd};

use super::errands::Errand;
use crate::port::Port;
use crate::replies::{Reply, Respond};
use crate::wire::Carrier;

/// Number of the descriptor that wakes the thread.
pub(super) const WAKE: u64 = 0;

/// Called when a connection that was asked for stands, or with the reason why it does not.
pub(crate) type Answer = Box<dyn FnOnce(Result<(), String>) + Send>;

/// What the thread is asked to do.
pub(crate) enum Command {
    /// Accept connections for a port.
    Listen { port: Arc<Port>, listener: TcpListener },
    /// Close a port and its connections.
    Close { port: u64 },
    /// Connect an out port to a reader.
    Link { port: Arc<Port>, to: String, at: SocketAddr, carrier: Carrier, answer: Option<Answer> },
    /// Dial, and exchange what the errand says.
    Errand { at: SocketAddr, errand: Box<dyn Errand> },
    /// Answer the message for which a connection waits.
    Reply { token: u64, reply: Reply },
}

/// Gives commands to the thread.
#[derive(Clone)]
pub(crate) struct Io(Arc<Shared>);

struct Shared {
    epoll: Arc<OwnedFd>,
    wake: OwnedFd,
    commands: Mutex<(Vec<Command>, bool)>,
    tokens: AtomicU64,
}

impl Io {
    pub(crate) fn new() -> io::Result<Self> {
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        let data = epoll::EventData::new_u64(WAKE);
        epoll::add(&epoll, &wake, data, epoll::EventFlags::IN)?;
        let (commands, tokens) = (Mutex::default(), AtomicU64::new(WAKE + 1));
        Ok(Self(Arc::new(Shared { epoll: Arc::new(epoll), wake, commands, tokens })))
    }

    pub(crate) fn submit(&self, command: Command) {
        self.0.commands.lock().unwrap_or_else(PoisonError::into_inner).0.push(command);
        self.wake();
    }

    /// Ends the thread, after the commands given before.
    pub(crate) fn end(&self) {
        self.0.commands.lock().unwrap_or_else(PoisonError::into_inner).1 = true;
        self.wake();
    }

    fn wake(&self) {
        // Fails only if it is awake anyway.
        let _ = rustix::io::write(&self.0.wake, &1u64.to_ne_bytes());
    }

    pub(super) fn commands(&self) -> (Vec<Command>, bool) {
        let mut buffer = [0; 8];
        let _ = rustix::io::read(&self.0.wake, &mut buffer);
        let mut commands = self.0.commands.lock().unwrap_or_else(PoisonError::into_inner);
        (std::mem::take(&mut commands.0), commands.1)
    }

    /// A number that no other connection or port has.
    pub(crate) fn token(&self) -> u64 {
        self.0.tokens.fetch_add(1, Ordering::Relaxed)
    }

    pub(super) fn epoll(&self) -> &Arc<OwnedFd> {
        &self.0.epoll
    }
}

impl Respond for Io {
    fn respond(&self, token: u64, reply: Reply) {
        self.submit(Command::Reply { token, reply });
    }
}
