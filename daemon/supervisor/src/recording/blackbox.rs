//! The black box of this process: the last samples, calls and changes, in memory that outlives it.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use genom_blackbox::{Memory, NoRoom, Track, Writer};
use genom_configuration::{BlackBoxReason, BlackBoxSection, is_one_of};
use genom_protocol::frames::Channel;
use serde_json::Value;

use super::notes::{SUBJECTS, Subject, subject};
use genom_bus::{Bus, Change, Numbered};

/// Ends an activity that somebody asked to end: nothing is wrong.
const INTERRUPTED: &str = "::genom::interrupted";

/// Writes to a memory what is to be kept.
pub struct BlackBox {
    writer: Writer,
    section: BlackBoxSection,
    subjects: Vec<Mutex<Track>>,
    bus: Arc<Bus>,
    /// Whether it was told that there is no room for a port.
    full: AtomicBool,
}

impl BlackBox {
    /// Begins to write to a memory that nobody has written to, and hears what `bus` tells.
    ///
    /// # Errors
    /// The memory cannot be mapped.
    pub fn begin(
        memory: &Memory,
        section: &BlackBoxSection,
        bus: &Arc<Bus>,
    ) -> io::Result<Arc<Self>> {
        let writer = Writer::new(memory)?;
        let most = usize::try_from(section.port_bytes).unwrap_or(usize::MAX);
        let track = |subject: Subject| {
            let head = serde_json::to_vec(&subject.head())?;
            writer.track(&head, most).map(Mutex::new).map_err(io::Error::other)
        };
        let subjects = SUBJECTS.into_iter().map(track).collect::<io::Result<Vec<_>>>()?;
        let (section, full) = (section.clone(), AtomicBool::new(false));
        let new = Arc::new(Self { writer, section, subjects, bus: Arc::clone(bus), full });
        let hears = Arc::downgrade(&new);
        bus.also(move |change| {
            if let Some(blackbox) = hears.upgrade() {
                blackbox.changed(change);
            }
        });
        Ok(new)
    }

    pub(super) fn wants_port(&self, address: &str) -> bool {
        is_one_of(&self.section.ports, address)
    }

    pub(super) fn wants_service(&self, component: &str, service: &str) -> bool {
        is_one_of(&self.section.services, &format!("{component}/{service}"))
    }

    /// A track for a port; `None` without room, which is told once.
    pub(super) fn track(&self, head: &Channel) -> Option<Track> {
        let most = usize::try_from(self.section.port_bytes).unwrap_or(usize::MAX);
        let text = serde_json::to_vec(head).unwrap_or_default();
        let made = self.writer.track(&text, most);
        let told = |why: NoRoom| {
            if !self.full.swap(true, Ordering::Relaxed) {
                tracing::warn!(
                    "the black box does not keep {}, and maybe not other ports: {why}; raise \
                     blackbox.bytes, or name fewer in blackbox.ports",
                    head.topic
                );
            }
        };
        made.map_err(told).ok()
    }

    pub(super) fn note(&self, on: Subject, moment: u64, content: &Value) {
        if let Some(track) = self.subjects.get(usize::from(on.channel())) {
            let text = content.to_string();
            track.lock().unwrap_or_else(PoisonError::into_inner).put(moment, text.as_bytes());
        }
    }

    fn changed(&self, change: &Numbered) {
        let (on, component) = subject(change);
        let service = change.data.get("service").and_then(Value::as_str);
        let wanted = match (on, component, service) {
            (Subject::Activities, Some(component), Some(service)) => {
                self.wants_service(component, service)
            }
            _ => true,
        };
        if wanted {
            self.note(on, change.moment, &change.data);
        }
    }

    /// A service ended with an exception: tells so where that is a reason to write a file.
    pub(super) fn exception(
        &self,
        component: &str,
        service: &str,
        activity: Option<u64>,
        exception: &str,
    ) {
        let chosen = || {
            is_one_of(&self.section.exceptions, &format!("{component}/{service}"))
                && self.section.is_on(BlackBoxReason::Exception)
        };
        if exception != INTERRUPTED && chosen() {
            let (component, service) = (component.to_owned(), service.to_owned());
            let exception = exception.to_owned();
            self.bus.tell(&Change::ServiceException { component, service, activity, exception });
        }
    }
}
