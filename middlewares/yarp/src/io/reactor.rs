//! The thread of connections: waits for events, and passes each to its connection.

use std::collections::HashMap;
use std::io;
use std::mem::MaybeUninit;
use std::net::TcpListener;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::event::epoll::{self, EventFlags};
use rustix::time::Timespec;

use super::commands::{Command, Io, WAKE};
use super::connections::{Around, Dialed, Purpose, Reactor, Source};
use super::errands::Lost;
use crate::port::{Port, Role};

/// Time between two looks at deadlines, while there are any.
const LOOK: Duration = Duration::from_millis(200);

/// Bytes read at once.
const SCRATCH: usize = 1 << 16;

/// Starts the thread.
pub(crate) fn start(io: &Io, around: Around) -> io::Result<JoinHandle<()>> {
    let io = io.clone();
    let thread = std::thread::Builder::new().name("yarp-io".to_owned());
    thread.spawn(move || run(io, around))
}

fn run(io: Io, around: Around) {
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
                    && let Role::Out(out) = &port.role
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
}
