//! All known ends, as they appear and disappear.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::dds::rustdds::{GUID, QosPolicies};
use genom_middleware::EndpointKind;
use genom_rosidl::TypeName;

use super::ends::{Entities, Found, Own, Verdict, Wanted, service_of};
use crate::dds::info::{self, End, Ends};
use crate::dds::process::Process;
use crate::rmw::Service;
use crate::settled::settled;

/// Number of absent daemons whose announcements are kept.
const MANY: usize = 256;

#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) own: HashMap<u64, Arc<Own>>,
    /// DDS entities that belong to our nodes and are not ends of ours.
    pub(super) others: HashMap<u64, Entities>,
    pub(super) next: u64,
    pub(super) found: HashMap<GUID, Found>,
    /// Announcements of daemons, by the writer that sent them.
    pub(super) told: HashMap<GUID, (Process, HashMap<GUID, End>)>,
}

/// All known ends.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    state: Mutex<State>,
    pub(super) changed: Condvar,
    /// Counts changes. A verdict is valid while this does not change.
    version: AtomicU64,
}

impl Graph {
    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn touch(&self) {
        self.version.fetch_add(1, Ordering::Release);
        self.changed.notify_all();
    }

    pub(crate) fn version(&self) -> u64 {
        self.version.load(Ordering::Acquire)
    }

    /// DDS discovered an end of others. Returns whether it was not known yet.
    pub(crate) fn found(&self, guid: GUID, found: Found) -> bool {
        let known = self.lock().found.insert(guid, found);
        self.touch();
        known.is_none()
    }

    /// DDS lost an end of others.
    pub(crate) fn lost(&self, guid: &GUID) {
        if self.lock().found.remove(guid).is_some() {
            self.touch();
        }
    }

    /// Removes the ends of participants that are gone. With `may_return` their announcements are
    /// kept, since they do not send them again when they come back.
    pub(crate) fn lost_all(&self, of: impl Fn(&GUID) -> bool, may_return: bool) -> Vec<Found> {
        let mut state = self.lock();
        let ends = state.found.extract_if(|guid, _| of(guid)).map(|(_, found)| found).collect();
        if !may_return || state.told.len() > MANY {
            state.told.retain(|guid, _| !of(guid));
        }
        drop(state);
        self.touch();
        ends
    }

    /// A daemon announced its ends; the list is complete.
    pub(crate) fn told(&self, by: GUID, ends: Ends) {
        let known = ends.ends.into_iter().map(|end| (end.guid(), end)).collect();
        self.lock().told.insert(by, (ends.process, known));
        self.touch();
    }

    /// What is known of a writer, for a reader of this type.
    pub(crate) fn writes(&self, writer: &GUID, digest: &str, dds_type: &str) -> Verdict {
        let state = self.lock();
        let gid = writer.to_bytes();
        let own =
            |own: &&Arc<Own>| own.made().as_ref().is_some_and(|made| made.writers.contains(&gid));
        if let Some(own) = state.own.values().find(own) {
            return Verdict::of(own.wanted.digest == digest);
        }
        let told = state.told.values().find_map(|(_, ends)| ends.get(writer));
        match (told, state.found.get(writer)) {
            (Some(end), Some(_)) => Verdict::of(end.digest == digest),
            (None, Some(_)) if state.is_daemon(writer) => Verdict::Unknown,
            (None, Some(found)) => Verdict::of(found.dds_type == dds_type),
            (_, None) => Verdict::Unknown,
        }
    }

    /// Whether a writer is a port of a genomd.
    pub(crate) fn is_told(&self, writer: &GUID) -> bool {
        self.lock().told_of(writer).is_some()
    }

    /// Whether a service exists, and its types if they are known to differ. Waits until `end` for
    /// one that is not known, since discovery takes time.
    pub(crate) fn service(&self, wanted: &Wanted, end: Instant) -> Service {
        let known = |found: &Service| *found != Service::Nobody;
        settled(&self.changed, self.lock(), end, |state| state.service(wanted), known).1
    }

    /// A reader of ours was recreated and has another GUID.
    pub(crate) fn renamed(&self, old: GUID, new: GUID) {
        let state = self.lock();
        let (old, new) = (old.to_bytes(), new.to_bytes());
        for own in state.own.values() {
            let mut made = own.made();
            let readers = made.iter_mut().flat_map(|made| &mut made.readers);
            readers.filter(|gid| **gid == old).for_each(|gid| *gid = new);
        }
        drop(state);
        self.touch();
    }

    /// Writers or readers of others on a topic, with their QoS.
    pub(crate) fn others(&self, topic: &str, writers: bool) -> Vec<(GUID, Found)> {
        let state = self.lock();
        let all = state.found.iter().filter(|(guid, found)| {
            found.topic == topic && found.writer == writers && !state.is_dead(guid)
        });
        all.map(|(guid, found)| (*guid, found.clone())).collect()
    }

    /// Our out port on a topic, and the QoS that it offers.
    pub(crate) fn writer(&self, topic: &str) -> Option<(Wanted, QosPolicies)> {
        let state = self.lock();
        let mut own = state.own.values().filter(|own| own.wanted.topic == topic);
        own.find_map(|own| Some((own.wanted.clone(), own.made().as_ref()?.offers.clone()?)))
    }
}

impl State {
    pub(super) fn service(&self, wanted: &Wanted) -> Service {
        let own = self
            .own
            .values()
            .map(|own| &own.wanted)
            .find(|own| own.kind == EndpointKind::Service && own.address == wanted.address);
        if let Some(own) = own {
            return service_of(&own.digest, &own.types, wanted, None);
        }
        let mut there = None;
        for (guid, other) in self.found.iter().filter(|(_, other)| other.topic == wanted.topic) {
            if other.writer || self.is_dead(guid) {
                continue;
            }
            match self.told_of(guid) {
                Some(end) => return service_of(&end.digest, &end.types, wanted, Some(*guid)),
                None if self.is_daemon(guid) => {}
                None if other.dds_type != wanted.dds_type => {
                    return Service::Differs(TypeName::from_dds(&other.dds_type));
                }
                None => there = Some(guid.to_bytes()),
            }
        }
        there.map_or(Service::Nobody, |guid| Service::There(Some(guid)))
    }

    pub(super) fn told_of(&self, guid: &GUID) -> Option<&End> {
        self.told.values().find_map(|(_, ends)| ends.get(guid))
    }

    /// Whether an end belongs to a daemon, which announces more about it.
    pub(super) fn is_daemon(&self, guid: &GUID) -> bool {
        let tells = |(other, found): (&GUID, &Found)| {
            other.prefix == guid.prefix && found.writer && found.topic == info::ENDS.0
        };
        self.told.keys().any(|by| by.prefix == guid.prefix) || self.found.iter().any(tells)
    }

    /// Whether an end belongs to a process that was killed; DDS notices that much later.
    pub(super) fn is_dead(&self, guid: &GUID) -> bool {
        let by = self.told.iter().find(|(by, _)| by.prefix == guid.prefix);
        by.is_some_and(|(_, (process, _))| process.has_ended())
    }
}
