//! A port that is open: its memory, which stays, and where the port is now.

use std::os::fd::OwnedFd;
use std::sync::Arc;

use genom_doors::RpcError;
use genom_protocol::Address;
use genom_supervisor::Supervisor;

use crate::far::Found;
use crate::memory::Memory;
use crate::port::{Port, gone, no_memory};
use crate::wire::{Opened, Taken};

#[derive(Debug)]
pub(crate) struct Open {
    pub(crate) address: Address,
    is_in: bool,
    size: usize,
    /// Of its type.
    digest: String,
    pub(crate) memory: Memory,
    /// The count, in the memory of an in port, of the value that was published last.
    published: u64,
    pub(crate) at: At,
}

/// Where a port is.
#[derive(Debug)]
pub(crate) enum At {
    /// In this process.
    Here(Port),
    /// In a process of a cell, at the other end of this socket, under a number there.
    There(Arc<OwnedFd>, u32),
    /// Its component is not there.
    Nowhere,
}

impl Open {
    /// A port of this process; its memory is new, unless it had one.
    pub(crate) fn here(address: Address, port: Port, memory: Memory) -> Self {
        Self {
            address,
            is_in: port.is_in(),
            size: port.ty().size(),
            digest: port.ty().digest().to_owned(),
            memory,
            published: 0,
            at: At::Here(port),
        }
    }

    /// A port of a cell.
    pub(crate) fn there(
        address: Address,
        found: Found,
        socket: &Arc<OwnedFd>,
        memory: Memory,
    ) -> Self {
        let Found { number, is_in, size, digest } = found;
        let at = At::There(Arc::clone(socket), number);
        Self { address, is_in, size, digest, memory, published: 0, at }
    }

    /// A port whose memory another process had, which had published the value of this count.
    pub(crate) fn published(self, published: u64) -> Self {
        Self { published, ..self }
    }

    /// What is told of it under this number.
    pub(crate) fn told(&self, number: u32) -> Opened<'_> {
        Opened { number, is_in: self.is_in, size: self.size as u64, digest: &self.digest }
    }

    /// What a cell has to know to go on with it.
    pub(crate) fn taken<'a>(&'a self, address: &'a str) -> Taken<'a> {
        Taken { published: self.published, is_in: self.is_in, digest: &self.digest, address }
    }

    /// Whether that is a port of the same kind and type.
    pub(crate) fn is_like(&self, is_in: bool, size: usize, digest: &str) -> bool {
        (self.is_in, self.size, self.digest.as_str()) == (is_in, size, digest)
    }

    /// The count of the value that is to be published, if there is one.
    pub(crate) fn written(&self) -> Result<Option<u64>, RpcError> {
        if !self.is_in {
            return Ok(None);
        }
        let written = self.memory.written();
        let count = written.map_err(|error| no_memory(&self.address, &error))?;
        Ok((count != self.published).then_some(count))
    }

    /// Publishes the value of an in port of this process, if it was written. Of another one it is
    /// noted only.
    pub(crate) fn publish(&mut self, supervisor: &Supervisor) -> Result<(), RpcError> {
        if let At::Here(port) = &mut self.at {
            return port.publish(supervisor, &self.memory, &mut self.published);
        }
        let Some(count) = self.written()? else { return Ok(()) };
        self.published = count;
        match self.at {
            At::Nowhere => Err(gone(&self.address)),
            At::Here(_) | At::There(..) => Ok(()),
        }
    }

    /// Shows the value of an out port of this process.
    pub(crate) fn show(&mut self, supervisor: &Supervisor) -> Result<(), RpcError> {
        match &mut self.at {
            At::Here(port) => port.show(supervisor, &self.memory),
            At::There(..) | At::Nowhere => Ok(()),
        }
    }

    /// Whether its component is not there, as far as this process knows.
    pub(crate) fn is_gone(&self) -> bool {
        match &self.at {
            At::Here(port) => port.is_gone(),
            At::There(..) => false,
            At::Nowhere => true,
        }
    }

    /// From now on it is there.
    pub(crate) fn goes_to(&mut self, at: At) -> Result<(), RpcError> {
        let gone = matches!(at, At::Nowhere);
        self.at = at;
        self.memory.set_gone(gone).map_err(|error| no_memory(&self.address, &error))
    }
}
