//! The thread of connections: waits for events, and passes each to its connection.

use std::collections::HashMap;
use std::mem::MaybeUninit;
use std::net::TcpListener;
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use rustix::event::epoll::{self, EventFlags};
use rustix::time::Timespec;

use super::dialed::{Dialed, Purpose};
use super::incoming::Incoming;
use super::{Command, Io, Lost, WAKE};
use crate::calls::Calls;
use crate::port::Port;
use crate::refusals::Refusals;
use crate::steward::Job;

/// Time between two looks at deadlines, while there are any.
const LOOK: Duration = Duration::from_millis(200);

/// Bytes read at once.
const SCRATCH: usize = 1 << 16;

/// What the thread has to do with.
pub(crate) struct Around {
    pub(crate) steward: Sender<Job>,
    pub(crate) calls: Arc<Calls>,
    pub(crate) refusals: Arc<Refusals>,
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
    /// Connections to close after the event.
    pub(super) cut: Vec<u64>,
}

pub(super) fn run(io: Io, around: Around) {
    if let Err(error) = genom_kit::prompt::be_prompt() {
        tracing::debug!(%error, "YARP's connections may wait for their turn");
    }
    let mut reactor = Reactor {
        io,
        around,
        sources: HashMap::new(),
        scratch: vec![0; SCRATCH],
        incoming: 0,
        held: 0,
        timed: false,
        cut: Vec::new(),
    };
    while reactor.turn() {}
    // Those who wait for an answer hear that there is none.
    for (_, source) in std::mem::take(&mut reactor.sources) {
        if let Source::Dialed(mut dialed) = source {
            dialed.purpose.lost(Lost::Gone);
        }
    }
}

impl Reactor {
    /// Waits for events once. Returns false at the end.
    fn turn(&mut self) -> bool {
        let mut events = [MaybeUninit::uninit(); 64];
        let look = Timespec { tv_sec: 0, tv_nsec: LOOK.subsec_nanos().into() };
        let timeout = self.timed.then_some(&look);
        let epoll = Arc::clone(self.io.epoll());
        let (events, _) = match epoll::wait(&*epoll, &mut events[..], timeout) {
            Ok(found) => found,
            Err(rustix::io::Errno::INTR) => return true,
            Err(error) => {
                tracing::error!(%error, "YARP's connections end: the system does not wait for them");
                return false;
            }
        };
        let mut goes_on = true;
        for event in events {
            match event.data.u64() {
                WAKE => goes_on = self.obey(),
                token => self.happened(token, event.flags),
            }
            while let Some(token) = self.cut.pop() {
                self.close(token, Lost::Gone);
            }
        }
        if self.timed {
            self.look();
        }
        goes_on
    }

    fn happened(&mut self, token: u64, flags: EventFlags) {
        // Taken out, so that it can use the rest of this.
        match self.sources.remove(&token) {
            Some(Source::Listener { listener, port, paused }) => {
                let paused = self.accept_all(&listener, &port, token) || paused;
                self.sources.insert(token, Source::Listener { listener, port, paused });
            }
            Some(Source::Incoming(mut incoming)) => {
                if self.incoming(token, &mut incoming, flags) {
                    self.sources.insert(token, Source::Incoming(incoming));
                } else {
                    self.incoming_ended(token, &incoming);
                }
            }
            Some(Source::Dialed(mut dialed)) => {
                let goes_on = self.dialed(token, &mut dialed, flags);
                let kept = goes_on.then_some(Source::Dialed(dialed));
                self.sources.extend(kept.map(|kept| (token, kept)));
            }
            // Closed by an earlier event of the same turn.
            None => {}
        }
    }

    fn obey(&mut self) -> bool {
        let (commands, end) = self.io.commands();
        for command in commands {
            match command {
                Command::Listen { port, listener } => self.listen(port, listener),
                Command::Close { port } => self.close_port(port),
                Command::Link { port, to, at, carrier, answer } => {
                    self.dial(at, Purpose::Link { port, to, carrier, answer });
                }
                Command::Errand { at, errand } => self.dial(at, Purpose::Errand(Some(errand))),
                Command::Reply { token, reply } => {
                    if let Some(Source::Incoming(mut incoming)) = self.sources.remove(&token) {
                        if self.reply(token, &mut incoming, reply) {
                            self.sources.insert(token, Source::Incoming(incoming));
                        } else {
                            self.incoming_ended(token, &incoming);
                        }
                    }
                }
            }
        }
        !end
    }

    fn listen(&mut self, port: Arc<Port>, listener: TcpListener) {
        let token = port.id;
        match self.watch(&listener, token, EventFlags::IN) {
            Ok(()) => {
                self.sources.insert(token, Source::Listener { listener, port, paused: false });
            }
            Err(error) => tracing::error!(name = port.name, %error, "a YARP port cannot listen"),
        }
    }

    fn close_port(&mut self, id: u64) {
        self.sources.remove(&id);
        let of_port = |source: &Source| match source {
            Source::Incoming(incoming) => incoming.port.id == id,
            Source::Dialed(Dialed { purpose: Purpose::Link { port, .. }, .. }) => port.id == id,
            _ => false,
        };
        let found = self.sources.iter().filter(|(_, source)| of_port(source));
        let tokens: Vec<u64> = found.map(|(token, _)| *token).collect();
        for token in tokens {
            match self.sources.remove(&token) {
                Some(Source::Dialed(mut dialed)) => {
                    let goes_on = self.finish(token, &mut dialed);
                    let kept = goes_on.then_some(Source::Dialed(dialed));
                    self.sources.extend(kept.map(|kept| (token, kept)));
                }
                Some(Source::Incoming(incoming)) => self.incoming_ended(token, &incoming),
                _ => {}
            }
        }
    }

    pub(super) fn close(&mut self, token: u64, how: Lost) {
        match self.sources.remove(&token) {
            Some(Source::Incoming(incoming)) => self.incoming_ended(token, &incoming),
            Some(Source::Dialed(mut dialed)) => {
                if let Purpose::Link { port, .. } = &dialed.purpose
                    && let crate::port::Role::Out(out) = &port.role
                {
                    out.leave(token);
                }
                dialed.purpose.lost(how);
            }
            Some(listener @ Source::Listener { .. }) => {
                self.sources.insert(token, listener);
            }
            None => {}
        }
    }

    /// Ends what is overdue, and lets paused listeners accept again.
    fn look(&mut self) {
        let now = Instant::now();
        let (mut due, mut later) = (Vec::new(), false);
        for (token, source) in &self.sources {
            let deadline = match source {
                Source::Incoming(incoming) => incoming.deadline,
                Source::Dialed(dialed) => dialed.deadline,
                Source::Listener { paused, .. } => paused.then_some(now),
            };
            match deadline {
                Some(deadline) if deadline <= now => due.push(*token),
                Some(_) => later = true,
                None => {}
            }
        }
        self.timed = later;
        for token in due {
            match self.sources.remove(&token) {
                Some(Source::Incoming(incoming)) => self.incoming_overdue(token, &incoming),
                Some(Source::Dialed(dialed)) => self.overdue(token, dialed),
                Some(Source::Listener { listener, port, .. }) => {
                    self.rewatch(&listener, token, EventFlags::IN);
                    self.sources.insert(token, Source::Listener { listener, port, paused: false });
                }
                None => {}
            }
        }
    }

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
