//! In ports on YARP, each shared by all that read the same out port.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use genom_middleware::{Address, OpenError};
use genom_types::DataType;

use crate::core::Core;
use crate::in_port::{InPort, Inbox};
use crate::mark;
use crate::port::{Port, Role};
use crate::steward::Asking;

/// Names and digests of the out ports that are read, with the in port that does.
#[derive(Default)]
pub(crate) struct Readers(Mutex<HashMap<(String, String), Weak<Reads>>>);

/// An in port on YARP, which all readers of one out port share.
struct Reads {
    port: Arc<Port>,
    core: Arc<Core>,
}

impl Drop for Reads {
    fn drop(&mut self) {
        self.core.close(&self.port);
    }
}

/// A reader's part of an in port.
pub(crate) struct Part {
    inbox: Arc<Inbox>,
    reads: Arc<Reads>,
}

impl Drop for Part {
    fn drop(&mut self) {
        if let Role::In(port) = &self.reads.port.role {
            port.leave(&self.inbox);
        }
    }
}

impl Readers {
    /// The in port that reads `name`, which is opened if there is none, with this inbox.
    pub(crate) fn join(
        &self,
        core: &Arc<Core>,
        at: &Address,
        name: &str,
        ty: &DataType,
        inbox: &Arc<Inbox>,
    ) -> Result<Part, OpenError> {
        // Held while it is opened: another reader that comes meanwhile shares it.
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|_, reads| reads.strong_count() > 0);
        let key = (name.to_owned(), ty.digest().to_owned());
        let reads = match all.get(&key).and_then(Weak::upgrade) {
            Some(reads) => reads,
            None => {
                let port = InPort::new(ty, name.to_owned());
                let (own, property) = (core.reader_of(name), mark::of_port(ty, true));
                let port = core.open(at, &own, property, Role::In(Arc::new(port)))?;
                let reads = Arc::new(Reads { port, core: Arc::clone(core) });
                all.insert(key, Arc::downgrade(&reads));
                // After it is registered: a writer that comes from now on finds it by itself.
                let source = core.names.query(name).ok().flatten();
                if let Some(at) = source.and_then(|source| source.address()) {
                    Asking::send(&core.io, &reads.port, at, core.settings.carrier);
                }
                core.names.announce(&own);
                core.look();
                reads
            }
        };
        drop(all);
        if let Role::In(port) = &reads.port.role {
            port.join(inbox);
        }
        Ok(Part { inbox: Arc::clone(inbox), reads })
    }
}
