//! Addresses claimed by our ends, and conflicts with the ends of others.

use std::sync::{Arc, Mutex};

use genom_middleware::{Address, OpenError};
use genom_rosidl::TypeName;

use super::ends::{Entities, Made, Own, Wanted, kind_of};
use super::known::{Graph, State};
use crate::conflict::{Conflict, is_alone, is_port, unopposed};

/// Keeps an end of ours registered, here and for others.
pub(crate) struct Claim {
    graph: Arc<Graph>,
    number: u64,
    own: Arc<Own>,
    /// Schedules an announcement of our ends.
    announce: Box<dyn Fn() + Send + Sync>,
}

/// Keeps DDS writers and readers registered as a node's.
pub(crate) struct Belonging {
    graph: Arc<Graph>,
    number: u64,
    announce: Box<dyn Fn() + Send + Sync>,
}

impl Graph {
    /// Registers an end of ours, unless it conflicts with another one.
    pub(crate) fn claim(
        self: &Arc<Self>,
        at: &Address,
        wanted: Wanted,
        announce: Box<dyn Fn() + Send + Sync>,
    ) -> Result<Claim, OpenError> {
        let look = |state: &State| state.conflict(&wanted);
        let mut state = unopposed(&self.changed, self.lock(), (at, &wanted.types), look)?;
        let own = Arc::new(Own { wanted, made: Mutex::default() });
        let number = state.next;
        state.next += 1;
        state.own.insert(number, Arc::clone(&own));
        drop(state);
        self.touch();
        Ok(Claim { graph: Arc::clone(self), number, own, announce })
    }

    /// Registers DDS writers and readers that are not an end of ours.
    pub(crate) fn belong(
        self: &Arc<Self>,
        entities: Entities,
        announce: Box<dyn Fn() + Send + Sync>,
    ) -> Belonging {
        let mut state = self.lock();
        let number = state.next;
        state.next += 1;
        state.others.insert(number, entities);
        drop(state);
        announce();
        Belonging { graph: Arc::clone(self), number, announce }
    }
}

impl State {
    /// The conflict with an existing end, if any, and whether that end is ours.
    fn conflict(&self, wanted: &Wanted) -> Option<(Conflict, bool)> {
        let (port, alone) = (is_port(wanted.kind), is_alone(wanted.kind));
        let ours = (wanted.kind, wanted.digest.as_str());
        let mut taken = None;
        let own = self.own.values().map(|own| &own.wanted);
        for other in own.filter(|other| other.address == wanted.address) {
            match Conflict::between(ours, (other.kind, &other.digest, &other.types)) {
                Some(Conflict::Taken) => taken = Some((Conflict::Taken, true)),
                Some(types) => return Some((types, true)),
                None => {}
            }
        }
        for (guid, found) in self.found.iter().filter(|(_, found)| found.topic == wanted.topic) {
            let told = self.told_of(guid);
            let same =
                told.map_or(found.dds_type == wanted.dds_type, |end| end.digest == wanted.digest);
            let clash = (port && !same)
                || (alone && told.is_some_and(|end| kind_of(end.kind) == Some(wanted.kind)));
            if !clash || self.is_dead(guid) {
                continue;
            }
            if port && !same {
                let foreign = || TypeName::from_dds(&found.dds_type);
                let theirs = told.map_or_else(foreign, |end| end.types.clone());
                return Some((Conflict::Types(theirs), false));
            }
            taken.get_or_insert((Conflict::Taken, false));
        }
        taken
    }
}

impl Claim {
    pub(crate) fn wanted(&self) -> &Wanted {
        &self.own.wanted
    }

    /// The end's DDS writers and readers now exist; schedules an announcement.
    pub(crate) fn made(&self, made: Made) {
        *self.own.made() = Some(made);
        self.graph.touch();
        (self.announce)();
    }
}

impl Drop for Belonging {
    fn drop(&mut self) {
        self.graph.lock().others.remove(&self.number);
        (self.announce)();
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.graph.lock().own.remove(&self.number);
        self.graph.touch();
        (self.announce)();
    }
}
