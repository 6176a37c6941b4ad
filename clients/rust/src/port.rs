//! Ports, in memory that the daemon shares with this program.

use bytemuck::{AnyBitPattern, NoUninit};

use crate::daemon::Daemon;
use crate::error::{OpenError, PortError};
use crate::memory::VALUE_AT;
use crate::shared::Shared;

/// An out port of a component.
#[derive(Debug)]
pub struct Out {
    shared: Shared,
}

impl Out {
    /// Shares the memory of an out port, `component/port`: each step shows there what codels wrote
    /// last.
    ///
    /// Its type has to be of one size, without unbounded strings or sequences. Its component may be in
    /// a cell, and begin again in another process: the memory stays.
    ///
    /// # Errors
    /// There is none that can be shared, or it is an in port.
    pub fn open(daemon: &mut Daemon, address: &str) -> Result<Self, OpenError> {
        let shared = daemon.open(address)?;
        if shared.is_in {
            return Err(OpenError::InPort(shared.address.clone()));
        }
        Ok(Self { shared })
    }

    /// `component/port`.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.shared.address
    }

    /// Bytes of a value.
    #[must_use]
    pub fn size(&self) -> usize {
        self.shared.memory.size()
    }

    /// How many samples codels had written at the last step; 0 if the port was never written.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.shared.memory.written()
    }

    /// What codels wrote last, as of the last step, in C layout. It is the memory itself, in which
    /// the next step writes: the daemon cannot be stepped as long as it is in use.
    ///
    /// # Errors
    /// The component is gone, or the port is of another daemon.
    pub fn bytes<'a>(&'a self, daemon: &'a Daemon) -> Result<&'a [u8], PortError> {
        if !daemon.has(&self.shared.door) {
            return Err(PortError::OtherDaemon(self.shared.address.clone()));
        }
        self.shared.check()?;
        // SAFETY: the daemon writes only while it answers a step, for which it has to be borrowed
        // mutably; this borrows it. Of an out port there are no slices that can be changed.
        Ok(unsafe { self.shared.memory.bytes() })
    }

    /// The same as a value.
    ///
    /// # Errors
    /// As for [`bytes`](Self::bytes); or the type has another size.
    pub fn value<'a, T: AnyBitPattern>(&'a self, daemon: &'a Daemon) -> Result<&'a T, PortError> {
        let bytes = self.bytes(daemon)?;
        bytemuck::try_from_bytes(bytes).map_err(|_| self.shared.other_size::<T>())
    }

    /// The memory of the value: steps write it.
    #[must_use]
    pub fn as_ptr(&self) -> *const u8 {
        self.shared.memory.value()
    }

    /// Whether the component is there, with a port of the same type.
    ///
    /// # Errors
    /// It is gone.
    pub fn check(&self) -> Result<(), PortError> {
        self.shared.check()
    }
}

/// An in port of a component, which this program writes.
#[derive(Debug)]
pub struct In {
    shared: Shared,
}

impl In {
    /// Shares the memory of an in port, `component/port`, which this program writes.
    ///
    /// # Errors
    /// As for [`Out::open`], the other way round.
    pub fn open(daemon: &mut Daemon, address: &str) -> Result<Self, OpenError> {
        let shared = daemon.open(address)?;
        if !shared.is_in {
            return Err(OpenError::OutPort(shared.address.clone()));
        }
        Ok(Self { shared })
    }

    /// `component/port`.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.shared.address
    }

    /// Bytes of a value.
    #[must_use]
    pub fn size(&self) -> usize {
        self.shared.memory.size()
    }

    /// How often this program has written it.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.shared.memory.written()
    }

    /// The value that [`write`](Self::write) publishes, in C layout. It is the memory itself.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        self.shared.memory.bytes_mut()
    }

    /// The same as a value.
    ///
    /// # Errors
    /// The type has another size.
    pub fn value_mut<T: AnyBitPattern + NoUninit>(&mut self) -> Result<&mut T, PortError> {
        if size_of::<T>() != self.size() || align_of::<T>() > VALUE_AT {
            return Err(self.shared.other_size::<T>());
        }
        // Of the same size, and at a multiple of its alignment.
        Ok(bytemuck::from_bytes_mut(self.bytes_mut()))
    }

    /// Has the next step publish the value, before anything runs. It is checked then.
    ///
    /// # Errors
    /// The component is gone.
    pub fn write(&mut self) -> Result<(), PortError> {
        self.shared.check()?;
        self.shared.memory.wrote();
        Ok(())
    }

    /// Whether the component is there, with a port of the same type.
    ///
    /// # Errors
    /// It is gone.
    pub fn check(&self) -> Result<(), PortError> {
        self.shared.check()
    }

    /// The memory of the value.
    #[must_use]
    pub fn as_ptr(&self) -> *const u8 {
        self.shared.memory.value()
    }

    /// The memory of the value, which the daemon only reads.
    #[must_use]
    pub fn as_mut_ptr(&mut self) -> *mut u8 {
        self.shared.memory.value()
    }
}
