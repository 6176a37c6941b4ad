//! The table of events: every string that codels may return, by index.

use genom_description::model::{Component, StateIx};
use genom_types::{Kind, ScopedName, TypeId, TypeTable};

use super::error::PlanError;
use crate::body::EventId;

/// An event and its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// Its full name: `::demo::main`, `::demo::pause::main`, `::demo::OUT_OF_RANGE`.
    pub name: String,
    /// Its meaning.
    pub meaning: Meaning,
}

/// Meaning of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A state of the component.
    State {
        /// The state.
        state: StateIx,
        /// `pause::`: wait for the next tick or event first.
        pause: bool,
    },
    /// An exception; its type when it is declared.
    Exception(Option<TypeId>),
}

/// Exceptions that every component can return, though no IDL declares them (genom3.md 4.8).
const ALWAYS: [&str; 3] = ["::genom::unkex", "::genom::syserr", "::genom::fatal"];

pub(super) fn table(model: &Component, types: &TypeTable) -> Result<Vec<Event>, PlanError> {
    let mut events = Vec::new();
    for (state, name) in model.states.pairs() {
        let meaning = Meaning::State { state, pause: false };
        events.push(Event { name: scoped(model, name), meaning });
    }
    for (state, name) in model.states.pairs() {
        let meaning = Meaning::State { state, pause: true };
        events.push(Event { name: scoped(model, &format!("pause::{name}")), meaning });
    }
    for (id, kind) in types.iter() {
        if let Kind::Exception { name, .. } = kind {
            events.push(Event { name: name.to_string(), meaning: Meaning::Exception(Some(id)) });
        }
    }
    for name in ALWAYS {
        if !events.iter().any(|event| event.name == name) {
            events.push(Event { name: name.to_owned(), meaning: Meaning::Exception(None) });
        }
    }
    if events.len() > usize::from(u16::MAX) {
        let (component, count) = (model.name.clone(), events.len());
        return Err(PlanError::TooManyEvents { component, count });
    }
    Ok(events)
}

/// Full name of an item in the component's scope.
fn scoped(model: &Component, name: &str) -> String {
    ScopedName::new([model.name.as_str(), name]).to_string()
}

/// A set of events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventSet(Box<[bool]>);

impl EventSet {
    /// The events of these exceptions.
    pub(super) fn of_exceptions(events: &[Event], throws: &[TypeId], types: &TypeTable) -> Self {
        let thrown: Vec<TypeId> = throws.iter().map(|id| types.resolve(*id)).collect();
        let is_thrown = |event: &Event| match event.meaning {
            Meaning::Exception(Some(id)) => thrown.contains(&id),
            _ => false,
        };
        Self(events.iter().map(is_thrown).collect())
    }

    /// The events of the set.
    pub(super) fn events(&self) -> impl Iterator<Item = EventId> + '_ {
        let all = self.0.iter().zip(0u16..);
        all.filter(|(is_in, _)| **is_in).map(|(_, rank)| EventId(rank))
    }

    /// Whether the set contains this event.
    #[must_use]
    pub fn contains(&self, event: EventId) -> bool {
        self.0.get(usize::from(event.0)).copied().unwrap_or(false)
    }
}
