//! The connections that the thread has, and what it keeps of each.

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use rustix::event::epoll::{self, EventFlags};

use super::commands::{Answer, Io};
use super::errands::Errand;
use crate::calls::Calls;
use crate::inbound::Inbound;
use crate::jobs::Job;
use crate::news::News;
use crate::port::Port;
use crate::refusals::Refusals;
use crate::wire::Carrier;

/// What the thread has to do with.
pub(crate) struct Around {
    pub(crate) steward: Sender<Job>,
    pub(crate) calls: Arc<Calls>,
    pub(crate) refusals: Arc<Refusals>,
    pub(crate) news: News,
    /// Greatest size of a message.
    pub(crate) largest: usize,
}

pub(super) enum Source {
    Listener { listener: TcpListener, port: Arc<Port>, paused: bool },
    Incoming(Incoming),
    Dialed(Dialed),
}

pub(super) struct Reactor {
    pub(super) io: Io,
    pub(super) around: Around,
    pub(super) sources: HashMap<u64, Source>,
    pub(super) scratch: Vec<u8>,
    /// Number of connections that others dialled, and the bytes that they hold.
    pub(super) incoming: usize,
    pub(super) held: usize,
    /// Whether some source has a deadline.
    pub(super) timed: bool,
}

/// A connection that another dialled.
pub(super) struct Incoming {
    pub(super) stream: TcpStream,
    pub(super) peer: IpAddr,
    pub(super) port: Arc<Port>,
    pub(super) inbound: Inbound,
    /// Name of the peer's port, once it has said it.
    pub(super) name: String,
    pub(super) carrier: Carrier,
    /// Answers that were not sent yet.
    pub(super) out: Vec<u8>,
    /// Whether it waits for an answer. Nothing more is read until then.
    pub(super) waits: bool,
    pub(super) deadline: Option<Instant>,
    /// When something came last.
    pub(super) heard: Instant,
    /// Bytes that it held when that was counted.
    pub(super) held: usize,
    /// The events that it is watched for.
    pub(super) interest: EventFlags,
}

/// A connection that this side dialled.
pub(super) struct Dialed {
    pub(super) stream: Arc<TcpStream>,
    pub(super) stage: Stage,
    /// What was not sent yet.
    pub(super) out: Vec<u8>,
    pub(super) heard: Vec<u8>,
    /// When the answer began whose end is missing.
    pub(super) amid: Option<Instant>,
    pub(super) deadline: Option<Instant>,
    pub(super) purpose: Purpose,
    pub(super) peer: SocketAddr,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Dialing,
    Greeting,
    Open,
    /// The port was closed; it ends when all is sent.
    Closing,
}

pub(super) enum Purpose {
    Link { port: Arc<Port>, to: String, carrier: Carrier, answer: Option<Answer> },
    Errand(Option<Box<dyn Errand>>),
}

impl Reactor {
    pub(super) fn watch(
        &self,
        source: impl AsFd,
        token: u64,
        flags: EventFlags,
    ) -> std::io::Result<()> {
        let data = epoll::EventData::new_u64(token);
        Ok(epoll::add(&**self.io.epoll(), source, data, flags)?)
    }

    pub(super) fn rewatch(&self, source: impl AsFd, token: u64, flags: EventFlags) {
        let data = epoll::EventData::new_u64(token);
        if let Err(error) = epoll::modify(&**self.io.epoll(), source, data, flags) {
            tracing::debug!(%error, "a YARP connection is not watched");
        }
    }
}
