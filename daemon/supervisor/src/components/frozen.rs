//! Writes the state of a component, between two of its codels.

use std::time::Duration;

use genom_description::model::{Owner, PortIx};
use genom_ports::PortKey;
use genom_protocol::{
    FrozenActivity, FrozenCall, FrozenComponent, FrozenPhase, FrozenState, FrozenValue, FrozenWait,
};
use genom_runtime::{ActivityPhase, FreezeError as Inner, Frozen, FrozenToken, Waiting};
use genom_types::{DataType, Kind, Record};

use super::hosted::Hosted;

/// Last values of ports, by name.
pub(super) type LastValues = Vec<(String, Option<Record>)>;

/// Name of the first native type in values of this type: pointers to what only the codels of one
/// library know.
pub(crate) fn native_in(ty: &DataType) -> Option<String> {
    // What holds no pointer at all is not searched.
    if ty.is_fixed_size() {
        return None;
    }
    if let Kind::Native { name } = ty.kind() {
        return Some(name.to_string());
    }
    let element = ty.element().and_then(|element| native_in(&element));
    element.or_else(|| (0..ty.member_count()).find_map(|rank| native_in(&ty.member(rank)?)))
}

/// A component could not be frozen.
#[derive(Debug, thiserror::Error)]
#[error("{component} cannot be frozen: {why}")]
pub struct FreezeError {
    /// Its instance name.
    pub component: String,
    /// Why.
    #[source]
    pub why: Inner,
}

impl Hosted {
    /// The state between two of its codels. Blocks for at most `patience`.
    ///
    /// # Errors
    /// Its codels leave no moment between them, or it stops.
    pub fn freeze(&self, patience: Duration) -> Result<FrozenComponent, FreezeError> {
        let keys = self.port_keys();
        let mut ports = LastValues::new();
        let mut also = || {
            let value = |(name, key): &(String, PortKey)| (name.clone(), self.last_value(key));
            ports = keys.iter().map(value).collect();
        };
        let frozen = self.instance.freeze(patience, &mut also);
        let frozen = frozen.map_err(|why| FreezeError { component: self.name.clone(), why })?;
        Ok(self.state_of(frozen, ports))
    }

    /// The last values of its ports, now.
    pub(super) fn last_values(&self) -> Vec<(String, PortKey, Option<Record>)> {
        let all = self.port_keys().into_iter();
        all.map(|(name, key)| {
            let value = self.last_value(&key);
            (name, key, value)
        })
        .collect()
    }

    /// The same by names.
    pub(super) fn state_of(&self, frozen: Frozen, ports: LastValues) -> FrozenComponent {
        let model = self.model();
        let mut state = FrozenComponent {
            component: model.name.clone(),
            digest: model.digest.clone(),
            ids: frozen.ids.as_ref().map(value),
            attributes: self.standing.attributes(),
            ..FrozenComponent::default()
        };
        for (name, last) in ports {
            match last {
                Some(last) => _ = state.ports.insert(name, value(&last)),
                None if self.was_used(&name) => state.ports_left_out.push(name),
                None => {}
            }
        }
        let executed = frozen.executed.into_iter();
        state.executed = executed.map(|service| model.services[service].name.clone()).collect();
        for activity in frozen.activities {
            let states = self.states(&activity.tokens);
            match (activity.owner, activity.memory) {
                (Owner::Task(task), _) => {
                    state.tasks.insert(model.tasks[task].name.clone(), states);
                }
                (Owner::Service(service), Some(memory)) => state.activities.push(FrozenActivity {
                    id: activity.id,
                    service: model.services[service].name.clone(),
                    phase: match activity.phase {
                        ActivityPhase::Init => FrozenPhase::Init,
                        ActivityPhase::Run => FrozenPhase::Run,
                        ActivityPhase::Stop | ActivityPhase::Ether => FrozenPhase::Stop,
                    },
                    pending: activity.pending,
                    stopped_by: activity.stopped_by,
                    states,
                    inputs: value(&memory.input),
                    outputs: value(&memory.output),
                    locals: value(&memory.local),
                }),
                (Owner::Service(_), None) => {}
            }
        }
        let deployed = self.standing.all_deployed().into_iter();
        state.deployed = deployed.map(|(service, inputs)| FrozenCall { service, inputs }).collect();
        state
    }

    /// Its ports, and elements of multiple ones, by name. What the runtime writes is not among them.
    fn port_keys(&self) -> Vec<(String, PortKey)> {
        let mut all = Vec::new();
        let ports = self.model().ports.pairs();
        for (port, model) in ports.filter(|(port, _)| Some(*port) != self.plan().state_port()) {
            if model.multiple {
                let elements = self.ties.elements(port).into_iter();
                all.extend(elements.map(|element| {
                    (format!("{}/{element}", model.name), key(port, Some(element)))
                }));
            } else {
                all.push((model.name.clone(), key(port, None)));
            }
        }
        all
    }

    /// Whether a sample went through a port.
    fn was_used(&self, name: &str) -> bool {
        let keys = self.port_keys();
        let key = keys.iter().find(|(known, _)| known == name).map(|(_, key)| key);
        let gauge = key.and_then(|key| self.ties.gauge(key));
        gauge.is_some_and(|gauge| gauge.counts().samples > 0)
    }

    fn states(&self, tokens: &[FrozenToken]) -> Vec<FrozenState> {
        let states = &self.model().states;
        let one = |token: &FrozenToken| FrozenState {
            state: states.get(token.state).cloned().unwrap_or_default(),
            waits: match token.waits {
                Waiting::Ready => FrozenWait::Ready,
                Waiting::Paused => FrozenWait::Pause,
                Waiting::Asleep => FrozenWait::Sleep,
            },
        };
        tokens.iter().map(one).collect()
    }
}

fn key(port: PortIx, element: Option<String>) -> PortKey {
    PortKey { port, element }
}

fn value(record: &Record) -> FrozenValue {
    let exact = record.to_exact_json();
    FrozenValue {
        digest: record.ty().digest().to_owned(),
        value: exact.value,
        left_out: exact.left_out.listed(),
    }
}
