//! Requests to a component whose effect lasts: attributes set, running activities, and what a
//! deployment called. They are written into dumps, and applying a deployment again skips what was
//! done already.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use genom_protocol::FrozenComponent;
use serde_json::Value;

/// Requests to one component whose effect lasts.
#[derive(Debug, Default)]
pub struct Standing {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Inputs of attributes as last set, by service.
    attributes: BTreeMap<String, Value>,
    /// Inputs of running activities, by number.
    activities: BTreeMap<u64, Value>,
    /// What a deployment called or started, in order: service and inputs.
    deployed: Vec<(String, Value)>,
}

impl Standing {
    /// An attribute was set to these inputs.
    pub(crate) fn attribute(&self, service: &str, inputs: Value) {
        self.with(|state| state.attributes.insert(service.to_owned(), inputs));
    }

    /// An activity was started with these inputs.
    pub(super) fn activity(&self, number: u64, inputs: Value) {
        self.with(|state| state.activities.insert(number, inputs));
    }

    /// An activity ended.
    pub(super) fn ended(&self, number: u64) {
        self.with(|state| state.activities.remove(&number));
    }

    /// A deployment called or started this service.
    pub fn deployed(&self, service: &str, inputs: Value) {
        self.with(|state| state.deployed.push((service.to_owned(), inputs)));
    }

    /// Inputs of all attributes that were set, by service.
    pub fn attributes(&self) -> BTreeMap<String, Value> {
        self.with(|state| state.attributes.clone())
    }

    /// Inputs of a running activity.
    pub fn inputs(&self, number: u64) -> Option<Value> {
        self.with(|state| state.activities.get(&number).cloned())
    }

    /// A deployment was undone: the attribute has its previous inputs again.
    pub fn attribute_back(&self, service: &str, before: Option<Value>) {
        self.with(|state| match before {
            Some(inputs) => state.attributes.insert(service.to_owned(), inputs),
            None => state.attributes.remove(service),
        });
    }

    /// A deployment was undone: forgets that it called this service.
    pub fn not_deployed(&self, service: &str, inputs: &Value) {
        self.with(|state| {
            let all = &mut state.deployed;
            if let Some(at) = all.iter().rposition(|one| one.0 == service && one.1 == *inputs) {
                all.remove(at);
            }
        });
    }

    /// What a deployment called or started, in order.
    pub fn all_deployed(&self) -> Vec<(String, Value)> {
        self.with(|state| state.deployed.clone())
    }

    /// The description is another one: forgets services that it does not have.
    pub(super) fn keep(&self, known: impl Fn(&str) -> bool) {
        self.with(|state| {
            state.attributes.retain(|service, _| known(service));
            state.deployed.retain(|(service, _)| known(service));
        });
    }

    /// What a state had of these services stands again.
    pub(super) fn remember(&self, earlier: &FrozenComponent, of: impl Fn(&str) -> bool) {
        self.with(|state| {
            let attributes = earlier.attributes.iter().filter(|(service, _)| of(service));
            state
                .attributes
                .extend(attributes.map(|(name, inputs)| (name.clone(), inputs.clone())));
            let deployed = earlier.deployed.iter().filter(|call| of(&call.service));
            let deployed = deployed.map(|call| (call.service.clone(), call.inputs.clone()));
            state.deployed.extend(deployed);
        });
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
