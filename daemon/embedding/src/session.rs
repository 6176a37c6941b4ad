//! Requests of the program, or of the daemon of a cell, one after the other.

use std::collections::BTreeMap;
use std::io;
use std::os::fd::{AsFd as _, OwnedFd};
use std::sync::Arc;
use std::time::Duration;

use genom_cells::Cells;
use genom_doors::RpcError;
use genom_lockstep::{Asked, End, Heard};
use genom_protocol::{Code, StepRequest};
use genom_supervisor::Supervisor;
use tokio::runtime::Handle;

use crate::open::Open;
use crate::places::Places;
use crate::short::{Returned, Short, untold};
use crate::who::Who;
use crate::wire::{self, LONGEST, Request, Taken, Verb};

/// What may be asked on a slate.
const STEP: u32 = Verb::Step as u32;
const PUBLISH: u32 = Verb::Publish as u32;

/// How many ports may be open.
const MOST: usize = 1024;

pub(crate) struct Session {
    end: End,
    who: Who,
    places: Places,
    /// Ports that are open, by their numbers: steps take them in the order in which they were opened.
    ports: BTreeMap<u32, Open>,
    /// Number of the next port.
    next: u32,
    /// Whether it was told that a request was none.
    told: bool,
    /// Short requests, if the other end has asked for their slate.
    short: Option<Short>,
}

impl Session {
    pub(crate) fn new(
        (socket, who): (&Arc<OwnedFd>, Who),
        supervisor: &Arc<Supervisor>,
        cells: &Arc<Cells>,
        runtime: Handle,
    ) -> Self {
        Self {
            end: End::new(Arc::clone(socket)),
            who,
            places: Places::new(supervisor, cells, runtime),
            ports: BTreeMap::new(),
            next: 0,
            told: false,
            short: None,
        }
    }

    /// Answers until the other end is closed: by a program, this daemon stops then.
    pub(crate) fn run(mut self) {
        // One byte more than a request has, to notice one that is longer.
        let mut message = [0; LONGEST + 1];
        loop {
            let heard = match &self.short {
                Some(short) => self.end.hear(&mut message, &short.slate),
                None => {
                    let received = self.end.receive(&mut message);
                    received.map(|(count, file)| Heard::Message(count, file))
                }
            };
            match heard {
                Ok(Heard::Asked(asked)) => self.answer_short(asked),
                Ok(Heard::Message(count, file)) if count > 0 => {
                    if self.answer(&message[..count], file).is_err() {
                        break;
                    }
                }
                _ => break,
            }
        }
        if self.who == Who::Program {
            let why = "the program that started this daemon has closed its socket";
            self.places.supervisor.ask_to_stop(why);
        }
    }

    fn answer(&mut self, message: &[u8], file: Option<OwnedFd>) -> io::Result<()> {
        // What is on the slate was asked before: this end slept then.
        if let Some(asked) = self.short.as_ref().and_then(|short| short.slate.asked()) {
            self.answer_short(asked);
        }
        let (number, asked) = wire::parse(message);
        let done = match asked {
            Ok(Request::Hello) => {
                let now = self.places.supervisor.clock.now().to_ne_bytes();
                Ok(wire::done(number, &[&now, env!("CARGO_PKG_VERSION").as_bytes()]))
            }
            Ok(Request::Step(nanoseconds)) => {
                self.step(nanoseconds).map(|returned| stepped(number, returned))
            }
            Ok(Request::Open(address)) => match self.open(address) {
                Ok(port) => return self.share(number, port),
                Err(error) => Err(error),
            },
            Ok(Request::Take(taken)) => self.take(number, &taken, file),
            Ok(Request::Close(port)) => match self.ports.remove(&port) {
                Some(open) => {
                    self.places.close(&open);
                    Ok(wire::done(number, &[]))
                }
                None => {
                    Err(RpcError::conflict(Code::NoSuchPort, format!("no port {port} is open")))
                }
            },
            Ok(Request::Publish) => self.publish().map(|()| wire::done(number, &[])),
            Ok(Request::Slate) => match Short::new() {
                Ok((short, file)) => {
                    self.short = Some(short);
                    let reply = wire::done(number, &[]);
                    return Ok(self.end.send([&reply, &[]], Some(file.as_fd()))?);
                }
                Err(error) => Err(RpcError::internal(format!("no memory is shared: {error}"))),
            },
            Ok(Request::Tell(asked)) => {
                let short = self.short.as_mut().ok_or_else(|| untold(asked));
                let returned = short.and_then(|short| short.tell(asked));
                returned.map(|returned| stepped(number, returned))
            }
            Err(why) => Err(self.none(why)),
        };
        let reply = done.unwrap_or_else(|error| refused(number, error));
        self.send(&reply)
    }

    /// Does what is asked on the slate.
    fn answer_short(&mut self, asked: Asked) {
        let returned = match asked.verb {
            STEP => self.step(asked.argument),
            PUBLISH => self.publish().map(|()| (0, 0)),
            _ => Err(self.none("only steps and publish are asked on a slate")),
        };
        if let Some(short) = &mut self.short {
            short.answer(asked.number, returned);
        }
    }

    /// A request is none.
    fn none(&mut self, why: &str) -> RpcError {
        if !self.told {
            self.told = true;
            let who = self.who;
            tracing::warn!("a request of the {who} is none: {why}; others are not told");
        }
        RpcError::conflict(Code::Malformed, format!("the request is none: {why}"))
    }

    /// Steps all.
    fn step(&mut self, nanoseconds: u64) -> Result<Returned, RpcError> {
        let supervisor = &self.places.supervisor;
        let clock = genom_views::stepped(supervisor)?;
        if nanoseconds > StepRequest::LONGEST {
            let message = format!(
                "a step of {nanoseconds} ns is too long: {} s are the most",
                StepRequest::LONGEST / 1_000_000_000
            );
            return Err(RpcError::bad_input(message));
        }
        if supervisor.stopping() {
            return Err(RpcError::conflict(Code::Stopping, "the daemon is stopping"));
        }
        self.places.settle(&mut self.ports)?;
        self.publish()?;
        self.places.step(nanoseconds)?;
        clock.step(Duration::from_nanos(nanoseconds));
        let mut gone = 0;
        for open in self.ports.values_mut() {
            open.show(&self.places.supervisor)?;
            gone += u32::from(open.is_gone());
        }
        Ok((clock.now(), gone))
    }

    /// Publishes what was written to in ports.
    fn publish(&mut self) -> Result<(), RpcError> {
        self.places.publish(&self.ports)?;
        for open in self.ports.values_mut() {
            open.publish(&self.places.supervisor)?;
        }
        Ok(())
    }

    /// Opens a port; returns its number.
    fn open(&mut self, address: &str) -> Result<u32, RpcError> {
        self.has_room()?;
        let open = self.places.open(address)?;
        Ok(self.add(open))
    }

    /// Goes on with a port.
    fn take(
        &mut self,
        number: u32,
        taken: &Taken<'_>,
        file: Option<OwnedFd>,
    ) -> Result<Vec<u8>, RpcError> {
        self.has_room()?;
        let Some(file) = file else {
            return Err(RpcError::conflict(Code::Malformed, "no memory came with the request"));
        };
        let open = self.places.take(taken, file)?;
        let reply = |port, open: &Open| wire::done(number, &[&open.told(port).bytes()]);
        let port = self.add(open);
        Ok(self.ports.get(&port).map_or_else(Vec::new, |open| reply(port, open)))
    }

    fn has_room(&self) -> Result<(), RpcError> {
        if self.ports.len() < MOST {
            return Ok(());
        }
        let message = format!("{MOST} ports are open, the most: close some");
        Err(RpcError::conflict(Code::TooManyStreams, message))
    }

    fn add(&mut self, open: Open) -> u32 {
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        self.ports.insert(number, open);
        number
    }

    /// Gives the memory of a port to the program.
    fn share(&self, number: u32, port: u32) -> io::Result<()> {
        let Some(open) = self.ports.get(&port) else { return Ok(()) };
        let reply = wire::done(number, &[&open.told(port).bytes()]);
        Ok(self.end.send([&reply, &[]], Some(open.memory.as_fd()))?)
    }

    fn send(&self, reply: &[u8]) -> io::Result<()> {
        Ok(self.end.send([reply, &[]], None)?)
    }
}

fn stepped(number: u32, (now, gone): Returned) -> Vec<u8> {
    wire::done(number, &[&now.to_ne_bytes(), &gone.to_ne_bytes()])
}

fn refused(number: u32, error: RpcError) -> Vec<u8> {
    // It has texts only, which are always JSON.
    wire::refused(number, &serde_json::to_vec(&error.refusal()).unwrap_or_default())
}
