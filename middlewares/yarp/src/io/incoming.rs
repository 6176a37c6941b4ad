//! Connections that others dialled.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::TcpListener;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::event::epoll::EventFlags;
use rustix::net::sockopt;

use super::connections::{Incoming, Reactor, Source};
use super::errands::Lost;
use crate::admin::{self, Then};
use crate::bottle::Value;
use crate::inbound::{Event, Inbound};
use crate::jobs::Job;
use crate::port::{Port, Role};
use crate::replies::{Reply, Respond as _};
use crate::wire::{self, Carrier, Purpose};

/// Greatest number of connections that others dialled, to all ports.
const MOST: usize = 1024;

/// Greatest number of bytes that they hold together.
const MOST_HELD: usize = 512 << 20;

/// How long one who dials may take to say who he is, and to go on with what he has begun.
const TO_GREET: Duration = Duration::from_secs(5);
const TO_GO_ON: Duration = Duration::from_secs(20);

/// Greatest number of bytes of answers that a peer does not take.
const MOST_UNSENT: usize = 80 << 20;

/// Greatest number of connections that a port takes before others have their turn.
const TURN: usize = 64;

/// What became of a look for a new connection.
enum Accepted {
    One,
    None,
    /// The system has no room for one.
    Pause,
}

impl Incoming {
    /// Whether it may have to make room for another: it sends no samples.
    fn may_go(&self) -> bool {
        let sends = matches!(self.port.role, Role::In(_)) && !self.carrier.is_text();
        self.name.is_empty() || !sends
    }
}

impl Reactor {
    /// Takes new connections. Returns whether the listener has to pause.
    pub(super) fn accept_all(&mut self, listener: &TcpListener, port: &Arc<Port>, id: u64) -> bool {
        for _ in 0..TURN {
            match self.accept(listener, port, id) {
                Accepted::One => {}
                Accepted::None => return false,
                Accepted::Pause => return true,
            }
        }
        false
    }

    fn accept(&mut self, listener: &TcpListener, port: &Arc<Port>, id: u64) -> Accepted {
        let (stream, peer) = match listener.accept() {
            Ok((stream, peer)) => (stream, peer.ip()),
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::ConnectionAborted
                ) =>
            {
                return Accepted::None;
            }
            // Out of descriptors: others may be closed soon.
            Err(error) => {
                self.around.refusals.add("no descriptor for a connection", None, &error);
                self.rewatch(listener, id, EventFlags::empty());
                self.timed = true;
                return Accepted::Pause;
            }
        };
        if self.incoming >= MOST && !self.make_room() {
            let detail = format!("to {}: {MOST} are open", port.name);
            self.around.refusals.add("too many connections", Some(peer), &detail);
            return Accepted::One;
        }
        let token = self.io.token();
        let _ = sockopt::set_tcp_nodelay(&stream, true);
        let _ = sockopt::set_socket_keepalive(&stream, true);
        let ready = stream.set_nonblocking(true);
        if let Err(error) = ready.and_then(|()| self.watch(&stream, token, EventFlags::IN)) {
            tracing::debug!(%error, "a YARP connection is not watched");
            return Accepted::One;
        }
        let now = Instant::now();
        let incoming = Incoming {
            stream,
            peer,
            inbound: Inbound::new(port.largest(self.around.largest)),
            port: Arc::clone(port),
            name: String::new(),
            carrier: Carrier::Tcp,
            out: Vec::new(),
            waits: false,
            deadline: Some(now + TO_GREET),
            heard: now,
            held: 0,
            interest: EventFlags::IN,
        };
        self.timed = true;
        self.incoming += 1;
        self.sources.insert(token, Source::Incoming(incoming));
        Accepted::One
    }

    /// Closes the connection that was silent for longest, of those that may go.
    fn make_room(&mut self) -> bool {
        let going = self.sources.iter().filter_map(|(token, source)| match source {
            Source::Incoming(incoming) if incoming.may_go() => {
                Some((incoming.waits, incoming.heard, *token))
            }
            _ => None,
        });
        let Some((_, _, token)) = going.min() else { return false };
        if let Some(Source::Incoming(incoming)) = self.sources.remove(&token) {
            let detail = format!("one from {:?} made room for another", incoming.name);
            self.around.refusals.add("too many connections", Some(incoming.peer), &detail);
            self.incoming_ended(token, &incoming);
        }
        true
    }

    pub(super) fn incoming_ended(&mut self, token: u64, incoming: &Incoming) {
        self.incoming -= 1;
        self.held -= incoming.held;
        if let Role::In(port) = &incoming.port.role
            && let Some(name) = port.gone(token)
        {
            self.around.news.tell(|| {
                tracing::info!(from = name, to = incoming.port.name, "a YARP connection ended");
            });
            // Another writer may be there already.
            let _ = self.around.steward.send(Job::Look);
        }
    }

    pub(super) fn incoming_overdue(&mut self, token: u64, incoming: &Incoming) {
        let (name, port) = (&incoming.name, &incoming.port.name);
        let detail = format!("{name:?} to {port} stopped amid what it said");
        self.around.refusals.add("a connection without an end", Some(incoming.peer), &detail);
        self.incoming_ended(token, incoming);
    }

    /// Something happened on a connection. Returns whether it goes on.
    pub(super) fn incoming(
        &mut self,
        token: u64,
        incoming: &mut Incoming,
        flags: EventFlags,
    ) -> bool {
        if flags.contains(EventFlags::OUT) && !self.write(token, incoming) {
            return false;
        }
        if incoming.waits {
            return !flags.intersects(EventFlags::HUP | EventFlags::ERR | EventFlags::RDHUP);
        }
        if flags.intersects(EventFlags::IN | EventFlags::HUP | EventFlags::ERR) {
            match incoming.stream.read(&mut self.scratch) {
                Ok(0) => return false,
                Ok(size) => incoming.inbound.push(self.scratch.get(..size).unwrap_or_default()),
                Err(error) => {
                    return matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted);
                }
            }
            incoming.heard = Instant::now();
        }
        self.understand(token, incoming)
    }

    /// Does what the bytes that have come say.
    fn understand(&mut self, token: u64, incoming: &mut Incoming) -> bool {
        while !incoming.waits {
            match incoming.inbound.next() {
                Ok(Some(event)) => {
                    if !self.event(token, incoming, event) {
                        return false;
                    }
                }
                Ok(None) => break,
                Err(abuse) => {
                    let detail = format!("{:?} to {} {abuse}", incoming.name, incoming.port.name);
                    let why = "what does not speak YARP";
                    self.around.refusals.add(why, Some(incoming.peer), &detail);
                    return false;
                }
            }
        }
        let amid = !incoming.waits && incoming.inbound.is_amid();
        let patience = if incoming.name.is_empty() { TO_GREET } else { TO_GO_ON };
        incoming.deadline = match incoming.deadline {
            // The greeting as a whole has to come in time, not each byte of it.
            Some(deadline) if amid && incoming.name.is_empty() => Some(deadline),
            _ => amid.then(|| incoming.heard + patience),
        };
        self.timed |= incoming.deadline.is_some();
        let held = incoming.inbound.held();
        self.held = self.held + held - incoming.held;
        incoming.held = held;
        if self.held > MOST_HELD && held > 1 << 20 {
            let detail = format!("one of {} to {}", incoming.name, incoming.port.name);
            let why = "messages that take too much memory together";
            self.around.refusals.add(why, Some(incoming.peer), &detail);
            return false;
        }
        self.write(token, incoming)
    }

    fn event(&mut self, token: u64, incoming: &mut Incoming, event: Event) -> bool {
        match event {
            Event::Hello { name, carrier } => {
                incoming.out.extend_from_slice(&match carrier.is_text() {
                    true => format!("Welcome {name}\r\n").into_bytes(),
                    false => wire::frame(incoming.port.at.port().into()).to_vec(),
                });
                // What people and tools ask in text is no connection.
                if let Role::In(port) = &incoming.port.role
                    && !carrier.is_text()
                {
                    port.connected(token, &name);
                }
                (incoming.name, incoming.carrier) = (name, carrier);
                true
            }
            Event::Bottle { purpose: Purpose::Data { reply }, body } => {
                self.data(token, incoming, reply, body)
            }
            Event::Bottle { purpose: Purpose::Administration, body } => {
                let body = incoming.inbound.bytes(body);
                let values = if incoming.carrier.is_text() {
                    let text = String::from_utf8_lossy(body);
                    Value::parse(&text).map_err(|error| error.to_string())
                } else if body.len() > 1 << 16 {
                    Err("it is too long".to_owned())
                } else {
                    Value::read(body).map_err(|error| error.to_string())
                };
                let then = match values {
                    Ok(values) => admin::ask(&incoming.port, &values),
                    Err(why) => Then::values([Value::vocab("fail"), Value::Text(why)]),
                };
                self.then(token, incoming, then)
            }
            Event::Command(word) if word == "q" => false,
            Event::Command(word) => {
                let then = admin::command(&incoming.port, &word, &incoming.name, incoming.carrier);
                self.then(token, incoming, then)
            }
        }
    }

    fn data(
        &mut self,
        token: u64,
        incoming: &mut Incoming,
        reply: bool,
        body: Range<usize>,
    ) -> bool {
        let bytes = incoming.inbound.bytes(body);
        let typed;
        let bottle = if incoming.carrier.is_text() {
            match Value::parse(&String::from_utf8_lossy(bytes)) {
                Ok(values) => typed = Value::to_bottle(&values),
                Err(error) => {
                    let text = format!("{error}\r\n");
                    return self.reply(token, incoming, Reply::Text(text));
                }
            }
            &typed
        } else {
            bytes
        };
        match &incoming.port.role {
            Role::In(port) => port.take(token, bottle, incoming.peer, &self.around.refusals),
            Role::Rpc(desk) => {
                incoming.waits = reply;
                let desk = Arc::clone(desk);
                let heard = self.around.calls.hear(desk, token, reply, bottle.to_vec());
                if heard {
                    return Self::acknowledge(incoming);
                }
                let busy =
                    Value::to_bottle(&[Value::from("error"), Value::from("too many requests")]);
                return !reply || self.reply(token, incoming, Reply::Bottle(busy));
            }
            // Nobody reads what is written to an out port.
            Role::Out(_) => {}
        }
        if reply {
            return self.reply(token, incoming, Reply::Bottle(Value::to_bottle(&[])));
        }
        Self::acknowledge(incoming)
    }

    /// Acknowledges a message that has no answer, or whose answer comes later with its own.
    fn acknowledge(incoming: &mut Incoming) -> bool {
        if incoming.waits {
            return true;
        }
        match incoming.carrier {
            Carrier::Tcp => incoming.out.extend_from_slice(&wire::ACK),
            Carrier::TextAck => incoming.out.extend_from_slice(b"<ACK>\r\n"),
            Carrier::FastTcp | Carrier::Text => {}
        }
        true
    }

    fn then(&mut self, token: u64, incoming: &mut Incoming, then: Then) -> bool {
        match then {
            Then::Reply(reply) => return self.reply(token, incoming, reply),
            Then::Cut { tokens, reply } => {
                // Before the answer: who has it may write at once, and that must not arrive. The one
                // who asks is taken out of the sources meanwhile, so that it is not closed here.
                for cut in tokens {
                    self.close(cut, Lost::Gone);
                }
                return self.reply(token, incoming, reply);
            }
            Then::Connect { to, carrier, answer } => {
                incoming.waits = true;
                let io = self.io.clone();
                let port = Arc::clone(&incoming.port);
                let answer = Box::new(move |made| {
                    io.respond(token, answer(made));
                });
                let job = Job::Connect { port, to, carrier, answer };
                if let Err(refused) = self.around.steward.send(job)
                    && let Job::Connect { answer, .. } = refused.0
                {
                    answer(Err("this side ends".to_owned()));
                }
            }
        }
        true
    }

    /// Answers a message, and goes on with what came after it.
    pub(super) fn reply(&mut self, token: u64, incoming: &mut Incoming, reply: Reply) -> bool {
        let waited = std::mem::take(&mut incoming.waits);
        match (reply, incoming.carrier.is_text()) {
            (Reply::Bottle(bottle), false) => incoming.out.extend_from_slice(&bottle),
            (Reply::Bottle(bottle), true) => {
                let values = Value::read(&bottle).unwrap_or_default();
                incoming.out.extend_from_slice(Value::line(&values).as_bytes());
                incoming.out.extend_from_slice(b"\r\n");
            }
            (Reply::Text(text), true) => incoming.out.extend_from_slice(text.as_bytes()),
            (Reply::Text(text), false) => {
                let line = Value::Text(text);
                incoming.out.extend_from_slice(&Value::to_bottle(&[line]));
            }
        }
        if incoming.out.len() > MOST_UNSENT {
            let detail = format!("{} does not read them", incoming.name);
            self.around.refusals.add("answers that nobody takes", Some(incoming.peer), &detail);
            return false;
        }
        Self::acknowledge(incoming)
            && self.write(token, incoming)
            && (!waited || self.understand(token, incoming))
    }

    /// Sends what the connection takes.
    fn write(&mut self, token: u64, incoming: &mut Incoming) -> bool {
        while !incoming.out.is_empty() {
            match incoming.stream.write(&incoming.out) {
                Ok(size) => drop(incoming.out.drain(..size)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            }
        }
        // One who does not read answers is not read either.
        let reads = !incoming.waits && incoming.out.len() < 1 << 16;
        let reads = if reads { EventFlags::IN } else { EventFlags::RDHUP };
        let writes = if incoming.out.is_empty() { EventFlags::empty() } else { EventFlags::OUT };
        if incoming.interest != reads | writes {
            incoming.interest = reads | writes;
            self.rewatch(&incoming.stream, token, incoming.interest);
        }
        true
    }
}
