//! A port that is open, of either kind.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::door::{Door, NoReply, Verb};
use crate::error::{OpenError, PortError};
use crate::memory::Memory;

/// A port that is open, until this is dropped.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) address: String,
    number: u32,
    pub(crate) is_in: bool,
    pub(crate) memory: Memory,
    pub(crate) door: Arc<Mutex<Door>>,
}

/// No panic of this crate leaves a door half-used: a request is answered or the door is closed.
pub(crate) fn lock(door: &Mutex<Door>) -> MutexGuard<'_, Door> {
    door.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    pub(crate) fn open(
        door: &Arc<Mutex<Door>>,
        address: &str,
    ) -> Result<Self, Result<OpenError, NoReply>> {
        let mut open = lock(door);
        let reply = open.ask(Verb::Open, address.as_bytes()).map_err(Err)?;
        let told = (reply.u32(0), reply.u32(4), reply.u64(8));
        let (Some(number), Some(is_in), Some(size)) = told else {
            return Err(Err(NoReply::Closed));
        };
        let mapped = match reply.file {
            None => Err(OpenError::NoFile(address.to_owned())),
            Some(file) => {
                let size = usize::try_from(size).unwrap_or(usize::MAX);
                Memory::new(file, size)
                    .map_err(|error| OpenError::Map { address: address.to_owned(), error })
            }
        };
        let memory = match mapped {
            Ok(memory) => memory,
            Err(error) => {
                // Nobody else would.
                let _ = open.ask(Verb::Close, &number.to_ne_bytes());
                return Err(Ok(error));
            }
        };
        drop(open);
        let (address, is_in, door) = (address.to_owned(), is_in == 1, Arc::clone(door));
        Ok(Self { address, number, is_in, memory, door })
    }

    pub(crate) fn check(&self) -> Result<(), PortError> {
        if self.memory.is_gone() { Err(PortError::Gone(self.address.clone())) } else { Ok(()) }
    }

    pub(crate) fn other_size<T>(&self) -> PortError {
        PortError::Size {
            address: self.address.clone(),
            size: self.memory.size(),
            type_name: std::any::type_name::<T>(),
            asked: size_of::<T>(),
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // A daemon that has ended has forgotten it.
        let _ = lock(&self.door).ask(Verb::Close, &self.number.to_ne_bytes());
    }
}
