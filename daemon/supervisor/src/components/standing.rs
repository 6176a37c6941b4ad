//! What was asked of a component and still stands: attributes set, activities that run, and what
//! a deployment called. Written into dumps; applying a deployment again looks here first.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

/// What stands of one component.
#[derive(Debug, Default)]
pub struct Standing {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Inputs of attributes, as last taken, by service.
    attributes: BTreeMap<String, Value>,
    /// Inputs of activities, by number.
    activities: BTreeMap<u64, Value>,
    /// What a deployment called or started, in order: service and inputs.
    deployed: Vec<(String, Value)>,
}

impl Standing {
    /// An attribute took these inputs.
    pub(super) fn attribute(&self, service: &str, inputs: Value) {
        self.with(|state| state.attributes.insert(service.to_owned(), inputs));
    }

    /// An activity started with these.
    pub(super) fn activity(&self, number: u64, inputs: Value) {
        self.with(|state| state.activities.insert(number, inputs));
    }

    /// An activity ended.
    pub(super) fn ended(&self, number: u64) {
        self.with(|state| state.activities.remove(&number));
    }

    /// A deployment had this called or started.
    pub fn deployed(&self, service: &str, inputs: Value) {
        self.with(|state| state.deployed.push((service.to_owned(), inputs)));
    }

    /// Attributes with their inputs.
    pub fn attributes(&self) -> BTreeMap<String, Value> {
        self.with(|state| state.attributes.clone())
    }

    /// Inputs of an activity that runs.
    pub fn inputs(&self, number: u64) -> Option<Value> {
        self.with(|state| state.activities.get(&number).cloned())
    }

    /// A deployment took back what it set: the attribute counts as it did before.
    pub fn attribute_back(&self, service: &str, before: Option<Value>) {
        self.with(|state| match before {
            Some(inputs) => state.attributes.insert(service.to_owned(), inputs),
            None => state.attributes.remove(service),
        });
    }

    /// A deployment was taken back: this was not called for it.
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

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
