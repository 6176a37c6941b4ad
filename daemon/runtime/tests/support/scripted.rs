//! The body: its codels return what the script says.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_description::model::{CodelIx, CodelKind, Ix as _, Owner, PortIx, RemoteIx, ServiceIx};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, Frame, Memory, Opener, RemoteCall, Returned};
use genom_runtime::{Plan, VirtualClock};
use genom_types::Record;
use serde_json::Value;

/// What one call of a codel returns.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    /// As written in the script: `main`, `pause::main`, `OUT_OF_RANGE`, `ok`, `crash`.
    pub(crate) event: String,
    pub(crate) detail: Option<Value>,
}

/// The script, and a trace of what happened.
#[derive(Debug, Default)]
pub(crate) struct Script {
    /// Results of the next calls of each codel; the last one is repeated.
    pub(crate) answers: HashMap<String, Vec<Answer>>,
    /// Lines added since the trace was last taken.
    pub(crate) trace: Vec<String>,
}

pub(crate) type Shared = Arc<Mutex<Script>>;

/// A component without library.
pub(crate) struct Scripted {
    pub(crate) plan: Arc<Plan>,
    pub(crate) script: Shared,
    pub(crate) clock: Arc<VirtualClock>,
}

impl Scripted {
    fn owner_name(&self, owner: Owner) -> String {
        let model = self.plan.component();
        match owner {
            Owner::Task(task) => model.tasks[task].name.clone(),
            Owner::Service(service) => model.services[service].name.clone(),
        }
    }
}

impl Body for Scripted {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        let (input, output) = match owner {
            Owner::Service(service) => {
                let service = &self.plan.services()[service];
                (Record::new(&service.input), Record::new(&service.output))
            }
            // The records of a permanent activity are not used.
            Owner::Task(_) => {
                let any = &self.plan.services()[ServiceIx::new(0)];
                (Record::new(&any.input), Record::new(&any.output))
            }
        };
        Box::new(ScriptedFrame {
            plan: Arc::clone(&self.plan),
            script: Arc::clone(&self.script),
            clock: Arc::clone(&self.clock),
            owner: self.owner_name(owner),
            input,
            output,
            last: Answer { event: "ok".into(), detail: None },
        })
    }

    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}

    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }

    fn write_port(&self, port: PortIx, value: &Record) {
        assert_eq!(Some(port), self.plan.state_port());
        let shown = value.to_json();
        let tasks = shown["task"].as_array().unwrap();
        let lists = tasks.iter().map(|task| {
            let list = task["activity"].as_array().unwrap().iter();
            let list = list.map(|a| format!("{}={}", a["id"], a["name"].as_str().unwrap()));
            format!("{}[{}]", task["name"].as_str().unwrap(), list.collect::<Vec<_>>().join(" "))
        });
        let line = format!("genom_state {}", lists.collect::<Vec<_>>().join(" "));
        let mut script = self.script.lock().unwrap();
        script.trace.push(format!("{} {line}", date(&self.clock)));
    }
}

fn date(clock: &VirtualClock) -> String {
    let us = clock.now() / 1000;
    if us.is_multiple_of(1000) { format!("{}ms", us / 1000) } else { format!("{us}us") }
}

struct ScriptedFrame {
    plan: Arc<Plan>,
    script: Shared,
    clock: Arc<VirtualClock>,
    owner: String,
    input: Record,
    output: Record,
    last: Answer,
}

impl ScriptedFrame {
    fn trace(&self, line: &str) {
        let line = format!("{} {}: {line}", date(&self.clock), self.owner);
        self.script.lock().unwrap().trace.push(line);
    }

    /// The next result of a codel; without script, success or the first state that it may yield.
    fn answer(&self, codel: CodelIx) -> Answer {
        let model = &self.plan.component().codels[codel];
        let mut script = self.script.lock().unwrap();
        if let Some(answers) = script.answers.get_mut(&model.name) {
            return if answers.len() > 1 { answers.remove(0) } else { answers[0].clone() };
        }
        let event = match &model.kind {
            CodelKind::Fsm { yields, .. } => {
                let state = &self.plan.component().states[yields[0].state];
                format!("{}{state}", if yields[0].pause { "pause::" } else { "" })
            }
            _ => "ok".into(),
        };
        Answer { event, detail: None }
    }

    fn full_name(&self) -> String {
        let event = &self.last.event;
        let scope = self.plan.component().scope();
        if event.starts_with("::") { event.clone() } else { format!("{scope}::{event}") }
    }
}

impl Frame for ScriptedFrame {
    fn begin(&mut self, input: &Record) {
        self.input.copy_from(input).unwrap();
        self.output.clear();
    }

    fn save(&self) -> Option<Memory> {
        let (input, output) = (self.input.clone(), self.output.clone());
        Some(Memory { local: output.clone(), input, output })
    }

    fn restore(&mut self, memory: &Memory) {
        self.input.copy_from(&memory.input).unwrap();
        self.output.copy_from(&memory.output).unwrap();
    }

    fn store(&mut self) {
        self.trace(&format!("ids <- {}", self.input.to_json()));
    }

    fn fetch(&mut self) {
        self.trace("outputs <- ids");
    }

    fn call(&mut self, codel: CodelIx, context: usize) -> Returned {
        assert!(context < self.plan.contexts());
        self.last = self.answer(codel);
        let name = &self.plan.component().codels[codel].name;
        self.trace(&format!("{name} -> {}", self.last.event));
        match self.last.event.as_str() {
            "ok" => Returned::Ok,
            "crash" => Returned::Failed,
            _ => self.plan.event(&self.full_name()).map_or(Returned::Unknown, Returned::Event),
        }
    }

    fn returned(&self) -> String {
        self.full_name()
    }

    fn detail(&self) -> Option<Value> {
        self.last.detail.clone()
    }

    fn output(&self) -> &Record {
        &self.output
    }
}
