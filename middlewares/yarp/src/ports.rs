//! Ports: how they are opened, and their ends as the runtime sees them.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use genom_kit::intake::{Intake, Keeping};
use genom_kit::mailbox::Mailbox;
use genom_kit::outlet::{Outlet, room_of};
use genom_middleware::describe::type_of_port;
use genom_middleware::{
    Address, OpenError, Policy, PortSpec, Ports, Publisher, ReadError, Reading, Subscription,
};
use genom_types::{DataType, Record};

use crate::backend::Yarp;
use crate::core::{Core, Presence};
use crate::error::{BACKEND, NameError};
use crate::in_port::Inbox;
use crate::io::Command;
use crate::line::Line;
use crate::mark::{self, Mark, Type};
use crate::names::{Contact, is_name};
use crate::out_port::OutPort;
use crate::port::Role;
use crate::readers::Part;

/// Greatest number of unsent samples per out port and connection, and of bytes that they may take.
const UNSENT: usize = 16;
const UNSENT_BYTES: usize = 1 << 20;

impl Core {
    pub(crate) fn checked_name(&self, at: &Address) -> Result<String, OpenError> {
        let name = self.name_of(at);
        if is_name(&name) { Ok(name) } else { Err(self.failed(at, NameError::Name(name))) }
    }

    fn mismatch(&self, at: &Address, ours: &DataType, theirs: &Type) -> OpenError {
        let (ours, theirs) = (type_of_port(ours), theirs.spelled.clone());
        OpenError::TypeMismatch { address: at.clone(), ours, theirs }
    }

    /// What a port says of itself; `None` for one that is no genomd's.
    pub(crate) fn mark_of(&self, contact: &Contact) -> Result<Option<Mark>, NameError> {
        match self.own(&contact.name) {
            Some(own) => Ok(Some(own)),
            None => Ok(Mark::parse(&self.names.get(&contact.name, mark::PROPERTY)?)),
        }
    }

    /// Refuses a name that another process has.
    pub(crate) fn check_free(&self, at: &Address, name: &str) -> Result<(), OpenError> {
        let found = self.names.query(name).map_err(|error| self.failed(at, error))?;
        let Some(contact) = found else { return Ok(()) };
        match self.presence(&contact) {
            Presence::Here => Err(OpenError::Taken { address: at.clone() }),
            Presence::Gone => {
                tracing::info!(name, "a YARP name is taken over from a process that ended");
                Ok(())
            }
            Presence::Silent => {
                let (host, port) = (&contact.host, contact.port);
                let why = format!(
                    "the name server has {name} at {host}:{port}, where something listens that \
                     does not answer: end it, or free the name (`yarp name unregister {name}`)"
                );
                Err(self.failed(at, why))
            }
        }
    }

    /// The in ports of others that read an out port. One of another type is an error.
    fn waiting_for(&self, port: &PortSpec<'_>, name: &str) -> Result<Vec<Contact>, OpenError> {
        let failed = |error| self.failed(port.address, error);
        let readers = self.names.list(&Core::readers_of(name)).map_err(failed)?;
        let mut waiting = Vec::new();
        for reader in readers {
            match self.mark_of(&reader).map_err(failed)? {
                Some(Mark::In(theirs)) if theirs.digest == port.ty.digest() => waiting.push(reader),
                // One that is still registered, but was killed, is no obstacle.
                Some(Mark::In(theirs)) if self.presence(&reader) == Presence::Here => {
                    return Err(self.mismatch(port.address, port.ty, &theirs));
                }
                _ => {}
            }
        }
        Ok(waiting)
    }
}

impl Ports for Yarp {
    fn publisher(&self, port: &PortSpec<'_>) -> Result<Box<dyn Publisher>, OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let core = &self.core;
        let name = core.checked_name(at)?;
        if core.own(&name).is_some() {
            return Err(OpenError::Taken { address: at.clone() });
        }
        core.check_free(at, &name)?;
        core.waiting_for(port, &name)?;
        let room = room_of(ty);
        let depth = (UNSENT_BYTES / room.max(1)).clamp(2, UNSENT);
        let out = Arc::new(OutPort::new(ty, depth));
        let own = core.open(at, &name, mark::of_port(ty, false), Role::Out(Arc::clone(&out)))?;
        // After it is registered: a reader that comes from now on finds it by itself.
        match core.waiting_for(port, &name) {
            Ok(waiting) => {
                for reader in waiting {
                    let Some(at) = reader.address() else { continue };
                    let (port, to, answer) = (Arc::clone(&own), reader.name, None);
                    let carrier = core.settings.carrier;
                    core.io.submit(Command::Link { port, to, at, carrier, answer });
                }
            }
            Err(error) => {
                core.close(&own);
                return Err(error);
            }
        }
        core.names.announce(&name);
        let outlet = Arc::new(Outlet::new(ty, depth, room));
        let line = Line { outlet: Arc::clone(&outlet), out: Arc::clone(&out) };
        let orders = core.sender.orders();
        let (line, core) = (orders.add(line), Arc::clone(core));
        let port = genom_kit::out_port::OutPort::new(outlet, orders, line, move |line| {
            core.sender.orders().remove(line, |_, line| drop(line));
            core.close(&own);
        });
        Ok(Box::new(port.and_lost(move || out.dropped())))
    }

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let core = &self.core;
        let Keeping { depth, full, counts } = Keeping::of(policy, BACKEND, ty)?;
        let name = core.checked_name(at)?;
        let source = core.names.query(&name).map_err(|error| core.failed(at, error))?;
        if let Some(writer) = &source
            && let Some(Mark::Out(theirs)) =
                core.mark_of(writer).map_err(|error| core.failed(at, error))?
            && theirs.digest != ty.digest()
            && core.presence(writer) == Presence::Here
        {
            return Err(core.mismatch(at, ty, &theirs));
        }
        let mailbox = Mailbox::new(depth, room_of(ty), full).dated();
        let inbox = Arc::new(Inbox::new(mailbox));
        let shared = self.readers.join(core, at, &name, ty, &inbox)?;
        Ok(Box::new(In { intake: Intake::new(ty), inbox, counts, _shared: shared }))
    }
}

/// The reading end.
struct In {
    intake: Intake,
    inbox: Arc<Inbox>,
    /// Whether overwritten samples count as lost.
    counts: bool,
    _shared: Part,
}

impl Subscription for In {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        let mailbox = &self.inbox.mailbox;
        let read = self.intake.read(into, |decode| mailbox.take(|sample| decode(sample)));
        self.counted(read)
    }

    fn read_message(&mut self, into: &mut Vec<u8>) -> Option<Result<Reading, ReadError>> {
        let mailbox = &self.inbox.mailbox;
        let read = self.intake.read_message(into, |see| mailbox.take(|sample| see(sample)));
        Some(self.counted(read))
    }

    fn on_arrival(&mut self, told: Box<dyn Fn() + Send + Sync>) -> bool {
        self.inbox.tell(told)
    }

    fn arrived(&self) -> Option<u64> {
        self.inbox.mailbox.put_at()
    }

    fn dropped(&self) -> u64 {
        let lost = if self.counts { self.inbox.mailbox.lost() } else { 0 };
        lost + self.inbox.misfits.load(Ordering::Relaxed)
    }
}

impl In {
    fn counted(&self, read: Result<Reading, ReadError>) -> Result<Reading, ReadError> {
        if read == Err(ReadError::Serialization) {
            self.inbox.misfits.fetch_add(1, Ordering::Relaxed);
        }
        read
    }
}
