//! Requests of the program, one after the other.

use std::collections::BTreeMap;
use std::io::{self, IoSlice};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd as _, OwnedFd};
use std::sync::Arc;
use std::time::Duration;

use genom_cells::{AskError, Cells};
use genom_doors::RpcError;
use genom_protocol::{Code, StepRequest};
use genom_supervisor::Supervisor;
use rustix::io::Errno;
use rustix::net::{
    RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, recv, send, sendmsg,
};
use tokio::runtime::Handle;

use crate::port::Port;
use crate::wire::{self, LONGEST, Request};

/// How many ports may be open.
const MOST: usize = 1024;

pub(crate) struct Session {
    socket: Arc<OwnedFd>,
    supervisor: Arc<Supervisor>,
    cells: Arc<Cells>,
    runtime: Handle,
    /// Ports that are open, by their numbers: steps take them in the order in which they were opened.
    ports: BTreeMap<u32, Port>,
    /// Number of the next port.
    next: u32,
    /// Whether it was told that a request was none.
    told: bool,
}

impl Session {
    pub(crate) fn new(
        socket: &Arc<OwnedFd>,
        supervisor: &Arc<Supervisor>,
        cells: &Arc<Cells>,
        runtime: Handle,
    ) -> Self {
        Self {
            socket: Arc::clone(socket),
            supervisor: Arc::clone(supervisor),
            cells: Arc::clone(cells),
            runtime,
            ports: BTreeMap::new(),
            next: 0,
            told: false,
        }
    }

    /// Answers until the program has closed its end.
    pub(crate) fn run(mut self) {
        // One byte more than a request has, to notice one that is longer.
        let mut message = [0; LONGEST + 1];
        loop {
            let count = match recv(&*self.socket, &mut message[..], RecvFlags::empty()) {
                Err(Errno::INTR) => continue,
                Ok((count, _)) if count > 0 => count,
                _ => break,
            };
            if self.answer(&message[..count]).is_err() {
                break;
            }
        }
        self.supervisor.ask_to_stop("the program that started this daemon has closed its socket");
    }

    fn answer(&mut self, message: &[u8]) -> io::Result<()> {
        let (number, asked) = wire::parse(message);
        let done = match asked {
            Ok(Request::Hello) => {
                let now = self.supervisor.clock.now().to_ne_bytes();
                Ok(wire::done(number, &[&now, env!("CARGO_PKG_VERSION").as_bytes()]))
            }
            Ok(Request::Step(nanoseconds)) => {
                self.step(nanoseconds).map(|now| wire::done(number, &[&now.to_ne_bytes()]))
            }
            Ok(Request::Open(address)) => match self.open(address) {
                Ok(port) => return self.share(number, port),
                Err(error) => Err(error),
            },
            Ok(Request::Close(port)) => match self.ports.remove(&port) {
                Some(_) => Ok(wire::done(number, &[])),
                None => {
                    Err(RpcError::conflict(Code::NoSuchPort, format!("no port {port} is open")))
                }
            },
            Err(why) => {
                if !self.told {
                    self.told = true;
                    tracing::warn!("a request of the program is none: {why}; others are not told");
                }
                Err(RpcError::conflict(Code::Malformed, format!("the request is none: {why}")))
            }
        };
        let reply = done.unwrap_or_else(|error| refused(number, error));
        self.send(&reply)
    }

    fn step(&mut self, nanoseconds: u64) -> Result<u64, RpcError> {
        let clock = genom_views::stepped(&self.supervisor)?;
        if nanoseconds > StepRequest::LONGEST {
            let message = format!(
                "a step of {nanoseconds} ns is too long: {} s are the most",
                StepRequest::LONGEST / 1_000_000_000
            );
            return Err(RpcError::bad_input(message));
        }
        if self.supervisor.stopping() {
            return Err(RpcError::conflict(Code::Stopping, "the daemon is stopping"));
        }
        for port in self.ports.values_mut() {
            port.publish(&self.supervisor)?;
        }
        if !self.cells.all().is_empty() {
            let stepped = self.runtime.block_on(self.cells.step(&StepRequest { nanoseconds }));
            stepped.map_err(|error| match error {
                AskError::Refused(_, reason) => RpcError::conflict(Code::CellDown, reason.message),
                error => RpcError::conflict(Code::CellDown, error.to_string()),
            })?;
        }
        clock.step(Duration::from_nanos(nanoseconds));
        for port in self.ports.values_mut() {
            port.show(&self.supervisor)?;
        }
        Ok(clock.now())
    }

    /// Opens a port; returns its number.
    fn open(&mut self, address: &str) -> Result<u32, RpcError> {
        if self.ports.len() >= MOST {
            let message = format!("{MOST} ports are open, the most: close some");
            return Err(RpcError::conflict(Code::TooManyStreams, message));
        }
        let component = address.split('/').next().unwrap_or_default();
        if let Some(cell) = self.cells.of(component) {
            let message = format!(
                "no component `{component}` in the process of the daemon: it runs in cell {}",
                cell.name()
            );
            return Err(RpcError::conflict(Code::NoSuchComponent, message)
                .help("read and publish its ports through the component: component.PORT"));
        }
        let port = Port::open(&self.supervisor, address)?;
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        self.ports.insert(number, port);
        Ok(number)
    }

    /// Gives the memory of a port to the program.
    fn share(&self, number: u32, port: u32) -> io::Result<()> {
        let Some(open) = self.ports.get(&port) else { return Ok(()) };
        let ty = open.ty();
        let reply = wire::done(
            number,
            &[
                &port.to_ne_bytes(),
                &u32::from(open.is_in()).to_ne_bytes(),
                &(ty.size() as u64).to_ne_bytes(),
                ty.digest().as_bytes(),
            ],
        );
        let files = [open.memory().as_fd()];
        let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut ancillary = SendAncillaryBuffer::new(&mut room);
        ancillary.push(SendAncillaryMessage::ScmRights(&files));
        sendmsg(&*self.socket, &[IoSlice::new(&reply)], &mut ancillary, SendFlags::NOSIGNAL)?;
        Ok(())
    }

    fn send(&self, reply: &[u8]) -> io::Result<()> {
        send(&*self.socket, reply, SendFlags::NOSIGNAL)?;
        Ok(())
    }
}

fn refused(number: u32, error: RpcError) -> Vec<u8> {
    // It has texts only, which are always JSON.
    wire::refused(number, &serde_json::to_vec(&error.refusal()).unwrap_or_default())
}
