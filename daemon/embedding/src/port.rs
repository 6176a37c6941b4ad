//! A port of a component in this process.

use std::fmt;
use std::io;
use std::sync::{Arc, Weak};

use genom_description::model::PortDirection;
use genom_doors::RpcError;
use genom_ports::PortKey;
use genom_protocol::address::NoAddress;
use genom_protocol::{Address, Code};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_supervisor::connections::feed::FeedError;
use genom_types::{DataType, Record};
use genom_views::{find, key, not_published};

use crate::memory::Memory;

/// The largest value that is shared, in bytes.
pub(crate) const LARGEST: usize = 256 << 20;

pub(crate) struct Port {
    address: Address,
    hosted: Weak<Hosted>,
    key: PortKey,
    ty: DataType,
    is_in: bool,
    gone: bool,
    /// The number of samples of an out port when its value was shown last.
    shown: Option<u64>,
    /// The bytes of an in port's value.
    room: Vec<u8>,
}

impl fmt::Debug for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Port({})", self.address)
    }
}

impl Port {
    /// The port at an address.
    pub(crate) fn find(supervisor: &Supervisor, text: &str) -> Result<Self, RpcError> {
        let address = parse(text)?;
        let hosted = find(&supervisor.components, &address.component)?;
        let key = key(&hosted, &address.port, address.element.clone())?;
        let Some(ty) = hosted.port_type(key.port) else {
            return Err(RpcError::internal(format!("{address} has no type")));
        };
        if !ty.is_fixed_size() || ty.size() > LARGEST {
            let message = format!(
                "{address} cannot be shared: values of {} are not of one size, or larger than 256 MiB",
                ty.name()
            );
            return Err(RpcError::bad_input(message)
                .help("read and publish it through the component: component.PORT"));
        }
        let is_in = direction(&hosted, &key) == PortDirection::In;
        Ok(Self {
            ty: ty.clone(),
            room: vec![0; if is_in { ty.size() } else { 0 }],
            shown: None,
            gone: false,
            hosted: Arc::downgrade(&hosted),
            is_in,
            address,
            key,
        })
    }

    /// Memory for its value, with the last one if there is one.
    pub(crate) fn memory(&mut self, supervisor: &Supervisor) -> Result<Memory, RpcError> {
        let memory = Memory::new(self.ty.size()).map_err(|error| self.no_memory(&error))?;
        if !self.is_in {
            self.show(supervisor, &memory)?;
            return Ok(memory);
        }
        let last = self.hosted.upgrade().and_then(|hosted| hosted.last_value(&self.key));
        let value = last.unwrap_or_else(|| Record::new(&self.ty));
        let written = value.bytes().map(|bytes| memory.write(bytes)).transpose();
        written.map_err(|error| self.no_memory(&error))?;
        Ok(memory)
    }

    pub(crate) fn is_in(&self) -> bool {
        self.is_in
    }

    pub(crate) fn ty(&self) -> &DataType {
        &self.ty
    }

    /// Whether its component is not there, as far as it was looked at.
    pub(crate) fn is_gone(&self) -> bool {
        self.gone
    }

    /// Publishes the value of an in port, as it is in its memory, unless that is the one of this count,
    /// which becomes its own.
    pub(crate) fn publish(
        &mut self,
        supervisor: &Supervisor,
        memory: &Memory,
        published: &mut u64,
    ) -> Result<(), RpcError> {
        if !self.is_in {
            return Ok(());
        }
        let new = memory.read_new(*published, &mut self.room);
        let Some(count) = new.map_err(|error| self.no_memory(&error))? else { return Ok(()) };
        // A value that is refused is refused once.
        *published = count;
        let Some(hosted) = self.hosted(supervisor, memory)? else {
            return Err(gone(&self.address));
        };
        let room = &self.room;
        let fill = |value: &mut Record| Ok::<_, FeedError>(value.set_bytes(room)?);
        let fed = supervisor.connections.feed(&hosted, &self.key, fill, |_| ());
        fed.map_err(|error| not_published(&error).place(self.address.to_string()))
    }

    /// Shows the value of an out port, if codels have written it since it was shown; says whether the
    /// port is gone.
    pub(crate) fn show(
        &mut self,
        supervisor: &Supervisor,
        memory: &Memory,
    ) -> Result<(), RpcError> {
        let Some(hosted) = self.hosted(supervisor, memory)? else { return Ok(()) };
        if self.is_in {
            return Ok(());
        }
        let samples = hosted.ties.gauge(&self.key).map_or(0, |gauge| gauge.counts().samples);
        if self.shown == Some(samples) {
            return Ok(());
        }
        // Of a large value that nobody had looked at there is no copy before the next one.
        let Some(value) = hosted.last_value(&self.key) else { return Ok(()) };
        let bytes = value.bytes().unwrap_or_default();
        memory.show(bytes, samples).map_err(|error| self.no_memory(&error))?;
        self.shown = Some(samples);
        Ok(())
    }

    /// The component, also one that has taken the place of the one that was there.
    fn hosted(
        &mut self,
        supervisor: &Supervisor,
        memory: &Memory,
    ) -> Result<Option<Arc<Hosted>>, RpcError> {
        if let Some(hosted) = self.hosted.upgrade().filter(|hosted| !hosted.gone.is_up()) {
            return Ok(Some(hosted));
        }
        let found = self.found(supervisor);
        if self.gone == found.is_some() {
            self.gone = found.is_none();
            memory.set_gone(self.gone).map_err(|error| self.no_memory(&error))?;
        }
        Ok(found.map(|(hosted, key)| {
            self.hosted = Arc::downgrade(&hosted);
            (self.key, self.shown) = (key, None);
            hosted
        }))
    }

    fn found(&self, supervisor: &Supervisor) -> Option<(Arc<Hosted>, PortKey)> {
        let Address { component, port, element } = &self.address;
        let hosted = find(&supervisor.components, component).ok()?;
        let key = key(&hosted, port, element.clone()).ok()?;
        let is_in = direction(&hosted, &key) == PortDirection::In;
        let same = hosted.port_type(key.port).is_some_and(|ty| ty.same_as(&self.ty));
        (same && is_in == self.is_in && !hosted.gone.is_up()).then_some((hosted, key))
    }

    fn no_memory(&self, error: &io::Error) -> RpcError {
        no_memory(&self.address, error)
    }
}

/// The address of a port.
pub(crate) fn parse(text: &str) -> Result<Address, RpcError> {
    text.parse().map_err(|error: NoAddress| RpcError::bad_input(error.to_string()))
}

/// A value was written to a port that is not there.
pub(crate) fn gone(address: &Address) -> RpcError {
    let message = format!("{address} is gone, or has another type now");
    RpcError::conflict(Code::NoSuchPort, message).help("open it again")
}

/// The memory of a port cannot be used.
pub(crate) fn no_memory(address: &Address, error: &io::Error) -> RpcError {
    RpcError::internal(format!("{address}: its memory cannot be used: {error}"))
}

fn direction(hosted: &Hosted, key: &PortKey) -> PortDirection {
    hosted.model().ports[key.port].direction
}
