//! The state of a component, made into what an instance of it takes: by the names of its
//! description, which may be another one than that of the state.

use genom_description::model::{Owner, PortIx};
use genom_protocol::{
    FrozenActivity, FrozenCall, FrozenComponent, FrozenPhase, FrozenState, FrozenValue, FrozenWait,
    Resumption,
};
use genom_runtime::body::Memory;
use genom_runtime::plan::Plan;
use genom_runtime::{
    ActivityPhase, FrozenActivity as Inner, FrozenPort, FrozenToken, ServiceIx, Waiting,
};
use genom_types::{DataType, Record};
use serde_json::Value;

/// A value that is not what was written: the file was changed or is damaged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{place}: {why}, although the description is the same: the file was changed or is damaged; \
     correct the value, or take away the whole of what it is in"
)]
pub struct Unfit {
    /// Path of the member, from the state of the component.
    pub place: String,
    /// What is wrong there.
    pub why: String,
}

/// What an instance is to take.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) ids: Option<Value>,
    pub(crate) ports: Vec<FrozenPort>,
    pub(crate) executed: Vec<ServiceIx>,
    pub(crate) permanent: Vec<Inner>,
    pub(crate) activities: Vec<Goal>,
    pub(crate) deployed: Vec<FrozenCall>,
    pub(crate) hold: bool,
    /// What is not taken over as it was.
    pub(crate) notes: Vec<String>,
}

/// An activity that is to go on.
#[derive(Debug)]
pub(crate) struct Goal {
    pub(crate) activity: Inner,
    /// Name of its service.
    pub(crate) service: String,
    /// Its inputs, for dumps.
    pub(crate) inputs: Value,
}

/// Finds by name what the state says.
pub(crate) fn prepare(plan: &Plan, resumption: &Resumption) -> Result<Prepared, Unfit> {
    let mut reader = Reader { plan, notes: Vec::new() };
    let Resumption { state, activities, hold, copy } = resumption;
    let model = plan.component();
    if state.component != model.name {
        return Err(Unfit {
            place: "component".to_owned(),
            why: format!("this is the state of a {}, and not of a {}", state.component, model.name),
        });
    }
    let mut prepared = Prepared {
        ids: reader.ids(state)?,
        ports: reader.ports(state)?,
        executed: Vec::new(),
        permanent: Vec::new(),
        activities: Vec::new(),
        deployed: Vec::new(),
        hold: *hold,
        notes: Vec::new(),
    };
    let executed = state.executed.iter();
    prepared.executed = executed.filter_map(|name| plan.service(name)).collect();
    if *activities {
        prepared.deployed.clone_from(&state.deployed);
        prepared.permanent = reader.permanent(state);
        for (at, activity) in state.activities.iter().enumerate() {
            prepared.activities.extend(reader.activity(at, activity)?);
        }
    }
    prepared.notes.extend(copy.iter().map(|copy| format!("it goes on with {copy}")));
    prepared.notes.extend(reader.notes);
    Ok(prepared)
}

struct Reader<'a> {
    plan: &'a Plan,
    notes: Vec<String>,
}

impl Reader<'_> {
    /// The value as a record of this type.
    fn record(&mut self, place: &str, ty: &DataType, from: &FrozenValue) -> Result<Record, Unfit> {
        let mut record = Record::new(ty);
        let told = record.take_over(&from.value);
        if from.digest == ty.digest() {
            let wrong =
                [(&told.unfit, ""), (&told.gone, " is no member"), (&told.new, " is missing")];
            for (list, what) in wrong {
                if let Some(first) = list.listed().into_iter().next() {
                    let (place, why) = (format!("{place}.value"), format!("{first}{what}"));
                    return Err(Unfit { place, why });
                }
            }
        }
        self.notes.extend(told.lines().into_iter().map(|line| format!("{place}: {line}")));
        Ok(record)
    }

    fn ids(&mut self, state: &FrozenComponent) -> Result<Option<Value>, Unfit> {
        let types = &self.plan.specification().types;
        let ty = self.plan.component().ids.and_then(|ids| DataType::new(types, ids).ok());
        match (&state.ids, ty) {
            (Some(from), Some(ty)) => {
                self.record("ids", &ty, from)?;
                self.notes.extend(from.left_out.iter().map(|path| {
                    format!("ids: {path} could not be written: it is as the start codels made it")
                }));
                Ok(Some(from.value.clone()))
            }
            (Some(_), None) => {
                self.notes.push("ids: the description has none any more".to_owned());
                Ok(None)
            }
            (None, _) => Ok(None),
        }
    }

    fn ports(&mut self, state: &FrozenComponent) -> Result<Vec<FrozenPort>, Unfit> {
        let mut all = Vec::new();
        for (name, from) in &state.ports {
            let place = format!("ports.{name}");
            let (port, element) = match name.split_once('/') {
                Some((port, element)) => (port, Some(element.to_owned())),
                None => (name.as_str(), None),
            };
            let model = &self.plan.component().ports;
            let found: Option<PortIx> =
                model.find(|known| known.name == port && known.multiple == element.is_some());
            let Some((port, ty)) = found.and_then(|port| Some((port, self.plan.port_type(port)?)))
            else {
                self.notes.push(format!("{place}: the description has no such port"));
                continue;
            };
            let value = self.record(&place, ty, from)?;
            all.push(FrozenPort { port, element, value });
        }
        let left_out = state.ports_left_out.iter();
        self.notes.extend(left_out.map(|name| format!("ports.{name}: its value was not kept")));
        Ok(all)
    }

    fn permanent(&mut self, state: &FrozenComponent) -> Vec<Inner> {
        let mut all = Vec::new();
        for (name, states) in &state.tasks {
            let place = format!("tasks.{name}");
            let Some(task) = self.plan.component().tasks.find(|task| task.name == *name) else {
                self.notes.push(format!("{place}: the description has no such task"));
                continue;
            };
            if let Some(tokens) = self.tokens(&place, states) {
                all.push(Inner {
                    id: 0,
                    owner: Owner::Task(task),
                    phase: ActivityPhase::Run,
                    pending: false,
                    stopped_by: None,
                    tokens,
                    memory: None,
                });
            }
        }
        all
    }

    fn activity(&mut self, at: usize, from: &FrozenActivity) -> Result<Option<Goal>, Unfit> {
        let place = format!("activities[{at}]");
        let found = self.plan.service(&from.service);
        let compiled =
            found.and_then(|service| Some((service, self.plan.services().get(service)?)));
        let Some((service, compiled)) = compiled.filter(|(_, compiled)| compiled.task.is_some())
        else {
            let name = &from.service;
            self.notes.push(format!(
                "{place}: {name} does not go on: the description has no such activity"
            ));
            return Ok(None);
        };
        let Some(tokens) = self.tokens(&place, &from.states) else { return Ok(None) };
        let local = self.plan.component().services[service].local;
        let Ok(local) = DataType::new(&self.plan.specification().types, local) else {
            return Ok(None);
        };
        let memory = Memory {
            input: self.record(&format!("{place}.inputs"), &compiled.input, &from.inputs)?,
            output: self.record(&format!("{place}.outputs"), &compiled.output, &from.outputs)?,
            local: self.record(&format!("{place}.locals"), &local, &from.locals)?,
        };
        let inputs = memory.input.to_json();
        let activity = Inner {
            id: from.id,
            owner: Owner::Service(service),
            phase: match from.phase {
                FrozenPhase::Init => ActivityPhase::Init,
                FrozenPhase::Run => ActivityPhase::Run,
                FrozenPhase::Stop => ActivityPhase::Stop,
            },
            pending: from.pending,
            stopped_by: from.stopped_by.clone(),
            tokens,
            memory: Some(memory),
        };
        Ok(Some(Goal { activity, service: from.service.clone(), inputs }))
    }

    /// The states; `None` if one of them is gone.
    fn tokens(&mut self, place: &str, states: &[FrozenState]) -> Option<Vec<FrozenToken>> {
        let mut tokens = Vec::new();
        for one in states {
            let Some(state) = self.plan.component().state(&one.state) else {
                let name = &one.state;
                self.notes.push(format!(
                    "{place}: it does not go on: the description has no state {name}"
                ));
                return None;
            };
            let waits = match one.waits {
                FrozenWait::Ready => Waiting::Ready,
                FrozenWait::Pause => Waiting::Paused,
                FrozenWait::Sleep => Waiting::Asleep,
            };
            tokens.push(FrozenToken { state, waits });
        }
        Some(tokens)
    }
}
