//! Connections that this side dialled: links to readers, and errands.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::event::epoll::EventFlags;
use rustix::net::{AddressFamily, SocketFlags, SocketType, connect, socket_with, sockopt};

use super::connections::{Dialed, Purpose, Reactor, Source, Stage};
use super::errands::{Lost, Step};
use crate::out_port::{Link, MOST_LINKS};
use crate::port::Role;
use crate::wire::{self, Carrier};

/// How long a peer may take to accept and to greet.
const TO_GREET: Duration = Duration::from_secs(3);

/// How long an answer may take from its first byte to its last one, and how much of it has to come
/// in each further millisecond.
const TO_END: Duration = Duration::from_secs(20);
const BYTES_IN_A_MILLISECOND: u64 = 100;

/// How long a closed port may take to send what is left.
const TO_FINISH: Duration = Duration::from_secs(1);

/// Greatest number of bytes of acknowledgements that were not understood yet.
const MOST_ACKNOWLEDGED: usize = 1 << 20;

impl Purpose {
    fn carrier(&self) -> Carrier {
        match self {
            Self::Link { carrier, .. } => *carrier,
            Self::Errand(errand) => {
                errand.as_ref().map_or(Carrier::FastTcp, |errand| errand.carrier())
            }
        }
    }

    /// Greatest number of bytes that are kept of what the peer says.
    fn most(&self) -> usize {
        match self {
            Self::Errand(Some(errand)) => errand.most(),
            Self::Link { .. } | Self::Errand(None) => MOST_ACKNOWLEDGED,
        }
    }

    fn patience(&self) -> Option<Duration> {
        match self {
            Self::Errand(Some(errand)) => errand.patience(),
            Self::Link { .. } | Self::Errand(None) => None,
        }
    }

    /// Tells those who wait that there is no connection, or no more.
    pub(super) fn lost(&mut self, how: Lost) {
        match self {
            Self::Link { answer, .. } => {
                if let Some(answer) = answer.take() {
                    answer(Err(match how {
                        Lost::Nobody => "nobody listens there".to_owned(),
                        Lost::Unreachable(why) => why,
                        Lost::Gone => "it ended the connection".to_owned(),
                        Lost::Late(_) => "it does not answer".to_owned(),
                    }));
                }
            }
            Self::Errand(errand) => {
                if let Some(errand) = errand.take() {
                    errand.lost(how);
                }
            }
        }
    }
}

fn dial(at: SocketAddr) -> std::io::Result<TcpStream> {
    let family = if at.is_ipv4() { AddressFamily::INET } else { AddressFamily::INET6 };
    let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
    let socket = socket_with(family, SocketType::STREAM, flags, None)?;
    let _ = sockopt::set_tcp_nodelay(&socket, true);
    let _ = sockopt::set_socket_keepalive(&socket, true);
    match connect(&socket, &at) {
        Ok(()) | Err(rustix::io::Errno::INPROGRESS) => Ok(TcpStream::from(socket)),
        Err(error) => Err(error.into()),
    }
}

impl Reactor {
    pub(super) fn dial(&mut self, at: SocketAddr, mut purpose: Purpose) {
        // A port that was closed meanwhile has a last sample, which is nobody's any more.
        if let Purpose::Link { port, .. } = &purpose
            && !self.sources.contains_key(&port.id)
        {
            return purpose.lost(Lost::Unreachable(format!("{} is closed", port.name)));
        }
        if let Purpose::Link { port, to, carrier, answer } = &mut purpose
            && let Role::Out(out) = &port.role
        {
            let same = out.links().into_iter().any(|(name, by)| name == *to && by == *carrier);
            let dialing = self.links_of(port.id).any(|other| other == to);
            let full = self.links_of(port.id).count() >= MOST_LINKS;
            if same || dialing || full {
                let most = format!("it has {MOST_LINKS} readers already");
                if let Some(answer) = answer.take() {
                    answer(if full && !same { Err(most) } else { Ok(()) });
                }
                return;
            }
        }
        let token = self.io.token();
        let stream = match dial(at) {
            Ok(stream) => Arc::new(stream),
            Err(error) => return purpose.lost(how(&error)),
        };
        if let Err(error) = self.watch(&*stream, token, EventFlags::OUT) {
            return purpose.lost(how(&error));
        }
        let dialed = Dialed {
            stream,
            stage: Stage::Dialing,
            out: Vec::new(),
            heard: Vec::new(),
            amid: None,
            deadline: Some(Instant::now() + TO_GREET),
            purpose,
            peer: at,
        };
        self.timed = true;
        self.sources.insert(token, Source::Dialed(dialed));
    }

    /// Names of the readers that an out port is connected to, or is about to be.
    fn links_of(&self, id: u64) -> impl Iterator<Item = &String> {
        self.sources.values().filter_map(move |source| match source {
            Source::Dialed(Dialed { purpose: Purpose::Link { port, to, .. }, stage, .. })
                if port.id == id && *stage != Stage::Closing =>
            {
                Some(to)
            }
            _ => None,
        })
    }

    /// Something happened on a connection. Returns whether it goes on.
    pub(super) fn dialed(&mut self, token: u64, dialed: &mut Dialed, flags: EventFlags) -> bool {
        match self.advance(token, dialed, flags) {
            Ok(()) => true,
            Err(how) => {
                if let Purpose::Link { port, to, .. } = &dialed.purpose
                    && let Role::Out(out) = &port.role
                    && out.leave(token).is_some()
                {
                    self.around.news.tell(|| {
                        tracing::info!(from = port.name, to, "a YARP connection ended");
                    });
                }
                if let Some(how) = how {
                    dialed.purpose.lost(how);
                }
                false
            }
        }
    }

    /// `Err` ends the connection; with the reason, if it is for those who wait.
    fn advance(
        &mut self,
        token: u64,
        dialed: &mut Dialed,
        flags: EventFlags,
    ) -> Result<(), Option<Lost>> {
        if dialed.stage == Stage::Dialing {
            if let Ok(Some(error)) | Err(error) = dialed.stream.take_error() {
                return Err(Some(how(&error)));
            }
            if !flags.contains(EventFlags::OUT) {
                return Ok(());
            }
            let name = match &dialed.purpose {
                Purpose::Link { port, .. } => port.name.as_str(),
                Purpose::Errand(_) => "admin",
            };
            dialed.out = wire::greeting(dialed.purpose.carrier(), name);
            dialed.stage = Stage::Greeting;
        }
        if flags.intersects(EventFlags::IN | EventFlags::HUP | EventFlags::ERR) {
            self.read_dialed(token, dialed)?;
        }
        if matches!(dialed.stage, Stage::Open | Stage::Closing)
            && let Purpose::Link { port, .. } = &dialed.purpose
            && let Role::Out(out) = &port.role
        {
            out.go_on(token, false);
            if dialed.stage == Stage::Closing && out.is_done(token) {
                return Err(None);
            }
            return Ok(());
        }
        self.write_dialed(token, dialed)
    }

    fn write_dialed(&mut self, token: u64, dialed: &mut Dialed) -> Result<(), Option<Lost>> {
        while !dialed.out.is_empty() {
            match (&*dialed.stream).write(&dialed.out) {
                Ok(size) => drop(dialed.out.drain(..size)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) => return Err(Some(how(&error))),
            }
        }
        let more = if dialed.out.is_empty() { EventFlags::empty() } else { EventFlags::OUT };
        self.rewatch(&*dialed.stream, token, EventFlags::IN | more);
        Ok(())
    }

    fn read_dialed(&mut self, token: u64, dialed: &mut Dialed) -> Result<(), Option<Lost>> {
        // Events come again while there is more.
        match (&*dialed.stream).read(&mut self.scratch) {
            Ok(0) => return Err(Some(Lost::Gone)),
            Ok(size) => {
                dialed.heard.extend_from_slice(self.scratch.get(..size).unwrap_or_default());
            }
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                return Ok(());
            }
            Err(error) => return Err(Some(how(&error))),
        }
        let most = dialed.purpose.most();
        if dialed.heard.len() > most {
            let why = format!("it answers with more than {most} bytes");
            let detail = format!("{}: {why}", dialed.peer);
            self.around.refusals.add("an answer that is too long", Some(dialed.peer.ip()), &detail);
            return Err(Some(Lost::Unreachable(why)));
        }
        if dialed.stage == Stage::Greeting && !self.greeted(token, dialed)? {
            return Ok(());
        }
        match &mut dialed.purpose {
            Purpose::Link { port, .. } => {
                let whole = dialed.heard.len() / 8 * 8;
                let acknowledged =
                    dialed.heard.drain(..whole).as_slice().chunks(8).any(|word| word == wire::ACK);
                if acknowledged && let Role::Out(out) = &port.role {
                    out.go_on(token, true);
                }
                Ok(())
            }
            Purpose::Errand(errand) => loop {
                let Some(one) = errand else { return Err(None) };
                match one.hear(&dialed.heard) {
                    Step::Wait => {
                        let now = Instant::now();
                        if dialed.heard.is_empty() {
                            dialed.deadline = one.patience().map(|patience| now + patience);
                        } else {
                            // From its first byte on, however small the pieces are.
                            let begun = *dialed.amid.get_or_insert(now);
                            let more = dialed.heard.len() as u64 / BYTES_IN_A_MILLISECOND;
                            dialed.deadline = Some(begun + TO_END + Duration::from_millis(more));
                        }
                        self.timed |= dialed.deadline.is_some();
                        return Ok(());
                    }
                    Step::Send(used, bytes) => {
                        dialed.amid = None;
                        dialed.heard.drain(..used.min(dialed.heard.len()));
                        dialed.out.extend_from_slice(&bytes);
                    }
                    Step::Done => {
                        *errand = None;
                        return Err(None);
                    }
                }
            },
        }
    }

    /// Whether the peer has greeted; if so, the connection is put to use.
    fn greeted(&mut self, token: u64, dialed: &mut Dialed) -> Result<bool, Option<Lost>> {
        let used = if dialed.purpose.carrier().is_text() {
            dialed.heard.iter().position(|byte| *byte == b'\n').map(|end| end + 1)
        } else {
            dialed.heard.first_chunk().map(|head| wire::framed(*head).map_or(0, |_| 8))
        };
        let Some(used) = used else { return Ok(false) };
        let welcome = used > 0 && (used == 8 || dialed.heard.starts_with(b"Welcome"));
        if !welcome {
            let said = dialed.heard.escape_ascii().to_string();
            let said: String = said.chars().take(60).collect();
            let why = format!("what is at {} is no YARP port: it says {said}", dialed.peer);
            return Err(Some(Lost::Unreachable(why)));
        }
        dialed.heard.drain(..used);
        dialed.stage = Stage::Open;
        dialed.deadline = None;
        match &mut dialed.purpose {
            Purpose::Errand(errand) => {
                if let Some(errand) = errand {
                    dialed.out.extend_from_slice(&errand.begin());
                }
            }
            Purpose::Link { port, to, carrier, answer } => {
                self.rewatch(&*dialed.stream, token, EventFlags::IN);
                let stream = Arc::clone(&dialed.stream);
                let epoll = Arc::clone(self.io.epoll());
                let link = Link::new((token, to.clone(), *carrier), stream, epoll);
                if let Role::Out(out) = &port.role
                    && let Some(former) = out.join(link)
                {
                    self.close(former, Lost::Gone);
                }
                let (from, by) = (&port.name, carrier.name());
                self.around.news.tell(|| tracing::info!(from, to, carrier = by, "YARP connection"));
                if let Some(answer) = answer.take() {
                    answer(Ok(()));
                }
            }
        }
        Ok(true)
    }

    /// The port of a connection was closed: it ends now, or when all is sent.
    pub(super) fn finish(&mut self, token: u64, dialed: &mut Dialed) -> bool {
        let Purpose::Link { port, .. } = &dialed.purpose else { return true };
        let Role::Out(out) = &port.role else { return true };
        if dialed.stage != Stage::Open || out.is_done(token) {
            out.leave(token);
            dialed.purpose.lost(Lost::Gone);
            return false;
        }
        dialed.stage = Stage::Closing;
        dialed.deadline = Some(Instant::now() + TO_FINISH);
        self.timed = true;
        true
    }

    /// The time of a connection is up.
    pub(super) fn overdue(&mut self, token: u64, mut dialed: Dialed) {
        if let Purpose::Link { port, .. } = &dialed.purpose
            && let Role::Out(out) = &port.role
        {
            out.leave(token);
        }
        let how = match dialed.purpose.patience() {
            _ if dialed.stage != Stage::Open => {
                let why = format!("{} does not answer within {TO_GREET:?}", dialed.peer);
                Lost::Unreachable(why)
            }
            _ if dialed.amid.is_some() => {
                let why = format!("{} stopped amid its answer", dialed.peer);
                let peer = Some(dialed.peer.ip());
                self.around.refusals.add("an answer without an end", peer, &why);
                Lost::Unreachable(why)
            }
            patience => Lost::Late(patience.unwrap_or_default()),
        };
        dialed.purpose.lost(how);
    }
}

fn how(error: &std::io::Error) -> Lost {
    match error.kind() {
        ErrorKind::ConnectionRefused => Lost::Nobody,
        ErrorKind::ConnectionReset | ErrorKind::BrokenPipe => Lost::Gone,
        _ => Lost::Unreachable(error.to_string()),
    }
}
