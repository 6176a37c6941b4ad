//! Replaces a network: a shared board through which participants of one process exchange samples.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use genom_kit::mailbox::Mailbox;
use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, OpenError, PortSpec};
use genom_types::DataType;

/// Every port that has an open end, with its type, last value and readers.
#[derive(Default)]
pub(crate) struct Board(Mutex<HashMap<Address, Port>>);

/// A port that has an open end.
pub(crate) struct Port {
    ty: DataType,
    pub(crate) has_writer: bool,
    last: Option<Vec<u8>>,
    readers: Vec<Weak<Inbox>>,
}

/// The samples that one reader has not read yet.
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox,
    /// Told of each sample.
    pub(crate) told: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Inbox {
    fn put(&self, sample: &[u8]) {
        let copy = |buffer: &mut Vec<u8>| {
            buffer.extend_from_slice(sample);
            Ok::<_, ()>(())
        };
        // The mailbox counts samples for which it has no space.
        let _ = self.mailbox.put(copy);
        self.told.get().into_iter().for_each(|told| told());
    }
}

impl Board {
    /// Finds or creates the board of that name. It exists until its last user drops it.
    pub(crate) fn named(name: &str) -> Arc<Self> {
        static BOARDS: Mutex<BTreeMap<String, Weak<Board>>> = Mutex::new(BTreeMap::new());
        let mut boards = lock(&BOARDS);
        boards.retain(|_, board| board.strong_count() > 0);
        let there = boards.get(name).and_then(Weak::upgrade);
        there.unwrap_or_else(|| {
            let new = Arc::new(Self::default());
            boards.insert(name.to_owned(), Arc::downgrade(&new));
            new
        })
    }

    /// Opens an end of a port. `end` registers it, or refuses.
    pub(crate) fn open(
        &self,
        port: &PortSpec<'_>,
        end: impl FnOnce(&mut Port) -> Result<(), OpenError>,
    ) -> Result<(), OpenError> {
        let PortSpec { address: at, ty, .. } = *port;
        let mut ports = lock(&self.0);
        ports.retain(|_, port| {
            port.has_writer || port.readers.iter().any(|reader| reader.strong_count() > 0)
        });
        let new = || Port { ty: ty.clone(), has_writer: false, last: None, readers: Vec::new() };
        let port = ports.entry(at.clone()).or_insert_with(new);
        if !port.ty.same_as(ty) {
            return Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: type_of_port(ty),
                theirs: type_of_port(&port.ty),
            });
        }
        end(port)
    }

    /// Delivers a sample to all readers of a port, and keeps it for readers that come later.
    pub(crate) fn deliver(&self, at: &Address, sample: &[u8]) {
        if let Some(port) = lock(&self.0).get_mut(at) {
            port.readers.iter().filter_map(Weak::upgrade).for_each(|reader| reader.put(sample));
            port.last = Some(sample.to_vec());
        }
    }

    /// Removes the writer of a port, and its last value.
    pub(crate) fn leave(&self, at: &Address) {
        if let Some(port) = lock(&self.0).get_mut(at) {
            (port.has_writer, port.last) = (false, None);
        }
    }
}

impl Port {
    /// Adds a reader: it gets the last value at once, and every sample from now on.
    pub(crate) fn join(&mut self, reader: &Arc<Inbox>) {
        self.last.iter().for_each(|last| reader.put(last));
        self.readers.retain(|other| other.strong_count() > 0);
        self.readers.push(Arc::downgrade(reader));
    }
}
