//! What a codel may return, numbered so that each is counted in a place of its own.

use genom_description::model::{Codel, CodelIx, CodelKind, Component, Indexed, Owner, ServiceIx};

use super::event::{Event, Meaning};
use super::machine::Transition;
use super::service::ServicePlan;
use crate::body::{EventId, Returned};
use crate::histogram::Counter;

/// Place of `genom_ok`.
const OK: u16 = 0;
/// Place of all that the codel must not return.
const OTHER: u16 = 1;
/// Place of the first event that it may return.
const FIRST: u16 = 2;

/// The places of one codel.
#[derive(Debug)]
pub(crate) struct Yields {
    /// The place of each event of the plan, up to the last one that the codel may return.
    places: Box<[u16]>,
    /// The events that it may return, in the order of their places.
    events: Box<[EventId]>,
}

impl Yields {
    fn new(may: impl Iterator<Item = EventId>) -> Self {
        let events: Box<[EventId]> = may.collect();
        let most = events.iter().map(|event| usize::from(event.0) + 1).max().unwrap_or(0);
        let mut places = vec![OTHER; most];
        for (event, place) in events.iter().zip(FIRST..) {
            places[usize::from(event.0)] = place;
        }
        Self { places: places.into(), events }
    }

    /// How many places there are.
    pub(crate) fn slots(&self) -> usize {
        usize::from(FIRST) + self.events.len()
    }

    /// The place of what was returned.
    #[inline]
    pub(crate) fn slot(&self, returned: Returned) -> usize {
        let place = match returned {
            Returned::Ok => OK,
            Returned::Event(event) => {
                self.places.get(usize::from(event.0)).copied().unwrap_or(OTHER)
            }
            Returned::Unknown | Returned::Failed => OTHER,
        };
        usize::from(place)
    }

    /// What was returned at least once, by the name that codels use, and how often; `events` are those
    /// of the plan.
    pub(crate) fn told(&self, events: &[Event], counts: &[Counter]) -> Vec<(String, u64)> {
        let names = ["ok".to_owned(), "other".to_owned()].into_iter();
        let names = names.chain(self.events.iter().map(|event| name(events, *event)));
        let all = names.zip(counts).map(|(name, count)| (name, count.read()));
        all.filter(|(_, count)| *count > 0).collect()
    }
}

/// `main`, `pause::main`, `::demo::OUT_OF_RANGE`.
fn name(events: &[Event], event: EventId) -> String {
    let Some(Event { name: whole, meaning }) = events.get(usize::from(event.0)) else {
        return String::new();
    };
    let state = matches!(meaning, Meaning::State { .. });
    let own = whole.strip_prefix("::").and_then(|name| name.split_once("::"));
    own.filter(|_| state).map_or(whole.as_str(), |(_, name)| name).to_owned()
}

/// The places of all codels.
pub(super) fn yields(
    model: &Component,
    transitions: &Indexed<CodelIx, Box<[Transition]>>,
    services: &Indexed<ServiceIx, ServicePlan>,
) -> Indexed<CodelIx, Yields> {
    let of_codel = |(ix, codel): (CodelIx, &Codel)| {
        if let CodelKind::Fsm { .. } = codel.kind {
            let table = transitions[ix].iter().zip(0u16..);
            return Yields::new(
                table.filter(|(to, _)| **to != Transition::Bad).map(|(_, id)| EventId(id)),
            );
        }
        let Owner::Service(service) = codel.owner else { return Yields::new(std::iter::empty()) };
        Yields::new(services[service].throws.events())
    };
    model.codels.pairs().map(of_codel).collect()
}
