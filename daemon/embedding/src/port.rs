//! A port that the program has opened.

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
const LARGEST: usize = 256 << 20;

pub(crate) struct Port {
    address: Address,
    hosted: Weak<Hosted>,
    key: PortKey,
    ty: DataType,
    is_in: bool,
    gone: bool,
    /// Of an in port: the count in its memory that was taken in last. Of an out port: the number of
    /// samples when its value was shown last.
    count: u64,
    /// The bytes of an in port's value.
    room: Vec<u8>,
    memory: Memory,
}

impl fmt::Debug for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Port({})", self.address)
    }
}

impl Port {
    /// Opens the port at an address. Its memory has the last value, if there is one.
    pub(crate) fn open(supervisor: &Supervisor, text: &str) -> Result<Self, RpcError> {
        let address: Address =
            text.parse().map_err(|error: NoAddress| RpcError::bad_input(error.to_string()))?;
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
        let mut port = Self {
            is_in: direction(&hosted, &key) == PortDirection::In,
            ty: ty.clone(),
            memory: Memory::new(ty.size()).map_err(|error| no_memory(&address, &error))?,
            room: Vec::new(),
            count: 0,
            gone: false,
            hosted: Arc::downgrade(&hosted),
            address,
            key,
        };
        if port.is_in {
            port.room.resize(port.ty.size(), 0);
            let value = hosted.last_value(&port.key).unwrap_or_else(|| Record::new(&port.ty));
            let written = value.bytes().map(|bytes| port.memory.write(bytes));
            written.transpose().map_err(|error| no_memory(&port.address, &error))?;
        } else {
            port.show(supervisor)?;
        }
        Ok(port)
    }

    pub(crate) fn is_in(&self) -> bool {
        self.is_in
    }

    pub(crate) fn ty(&self) -> &DataType {
        &self.ty
    }

    pub(crate) fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Publishes the value of an in port, if the program has written it since the last step.
    pub(crate) fn publish(&mut self, supervisor: &Supervisor) -> Result<(), RpcError> {
        if !self.is_in {
            return Ok(());
        }
        let hosted = self.hosted(supervisor)?;
        let written = self.memory.written();
        let count = written.map_err(|error| no_memory(&self.address, &error))?;
        if count == self.count {
            return Ok(());
        }
        // A value that is refused is refused once.
        self.count = count;
        let Some(hosted) = hosted else {
            let message = format!("{} is gone, or has another type now", self.address);
            return Err(RpcError::conflict(Code::NoSuchPort, message).help("open it again"));
        };
        self.memory.read(&mut self.room).map_err(|error| no_memory(&self.address, &error))?;
        let room = &self.room;
        let fill = |value: &mut Record| Ok::<_, FeedError>(value.set_bytes(room)?);
        let fed = supervisor.connections.feed(&hosted, &self.key, fill, |_| ());
        fed.map_err(|error| not_published(&error).place(self.address.to_string()))
    }

    /// Shows the value of an out port, if codels have written it since it was shown.
    pub(crate) fn show(&mut self, supervisor: &Supervisor) -> Result<(), RpcError> {
        let Some(hosted) = self.hosted(supervisor)? else { return Ok(()) };
        if self.is_in {
            return Ok(());
        }
        let samples = hosted.ties.gauge(&self.key).map_or(0, |gauge| gauge.counts().samples);
        if samples == self.count {
            return Ok(());
        }
        // Of a large value that nobody had looked at there is no copy before the next one.
        let Some(value) = hosted.last_value(&self.key) else { return Ok(()) };
        let bytes = value.bytes().unwrap_or_default();
        let written = self.memory.write(bytes).and_then(|()| self.memory.set_written(samples));
        written.map_err(|error| no_memory(&self.address, &error))?;
        self.count = samples;
        Ok(())
    }

    /// The component, also one that has taken the place of the one that was there.
    fn hosted(&mut self, supervisor: &Supervisor) -> Result<Option<Arc<Hosted>>, RpcError> {
        if let Some(hosted) = self.hosted.upgrade().filter(|hosted| !hosted.gone.is_up()) {
            return Ok(Some(hosted));
        }
        let found = self.found(supervisor);
        if self.gone == found.is_some() {
            self.gone = found.is_none();
            let told = self.memory.set_gone(self.gone);
            told.map_err(|error| no_memory(&self.address, &error))?;
        }
        Ok(found.map(|(hosted, key)| {
            self.hosted = Arc::downgrade(&hosted);
            self.key = key;
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
}

fn direction(hosted: &Hosted, key: &PortKey) -> PortDirection {
    hosted.model().ports[key.port].direction
}

fn no_memory(address: &Address, error: &io::Error) -> RpcError {
    RpcError::internal(format!("{address}: its memory cannot be used: {error}"))
}
