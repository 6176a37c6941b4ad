//! Components with `lang "c++"`, from the texts of a description and its codels.
#![allow(dead_code)]

use std::path::PathBuf;
use std::sync::Arc;

use genom_description::model::{CodelKind, Ix as _, Owner, PortIx, ServiceIx, Span, TaskIx};
use genom_description_tools::{Language, header};
use genom_host::{Component, Library, LoadErrors};
use genom_runtime::body::{Body, Frame, Returned};
use genom_runtime::plan::Plan;
use genom_types::{DataType, Record};
use serde_json::Value;

use super::Scratch;

/// A library of codels.
pub(crate) struct Compiled {
    pub(crate) library: PathBuf,
    _scratch: Scratch,
}

/// A loaded component.
pub(crate) struct Loaded {
    pub(crate) component: Component,
    pub(crate) plan: Plan,
    _compiled: Option<Arc<Compiled>>,
}

/// Compiles codels against the header of `text`.
pub(crate) fn compile(text: &str, codels: &str, flags: &[&str]) -> Arc<Compiled> {
    let scratch = Scratch::new();
    let written = genom_description::read_text("demo.gen", text, &Default::default());
    assert!(!written.has_errors(), "{:?}", written.diagnostics);
    let header = header(&written.specification, None, Language::Cxx).expect("a header");
    scratch.file("demo_types.hh", header.as_bytes());
    let include = format!("-I{}", scratch.path().display());
    let all = ["-shared", "-fPIC", "-Wextra", "-Werror", &include];
    let all: Vec<&str> = all.iter().chain(flags).copied().collect();
    let source = format!("#include \"demo_types.hh\"\n{codels}");
    let library = scratch.cxx("demo.so", &source, &all);
    Arc::new(Compiled { library, _scratch: scratch })
}

/// Plan of a description, and a function that formats positions.
pub(crate) fn plan(text: &str) -> (Plan, impl Fn(Span) -> String) {
    let analysis = genom_description::read_text("demo.gen", text, &Default::default());
    assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).expect("a plan");
    let sources = analysis.sources;
    (plan, move |span| format!("demo.gen:{}", sources.location(span).line))
}

/// Loads a library with the description `text`.
pub(crate) fn try_load(compiled: &Arc<Compiled>, text: &str) -> Result<Loaded, LoadErrors> {
    let (plan, locate) = plan(text);
    let opened = Library::open(&compiled.library).expect("a library");
    let component = Component::load(opened, &plan, &locate)?;
    Ok(Loaded { component, plan, _compiled: Some(Arc::clone(compiled)) })
}

/// Loads a library that must be accepted.
#[track_caller]
pub(crate) fn load(compiled: &Arc<Compiled>, text: &str) -> Loaded {
    try_load(compiled, text).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The error of a library that must be refused, without the directory.
#[track_caller]
pub(crate) fn refusal(compiled: &Arc<Compiled>, text: &str) -> String {
    match try_load(compiled, text) {
        Ok(_) => "loads".to_owned(),
        Err(errors) => errors.to_string().replace(&errors.library.display().to_string(), "demo.so"),
    }
}

impl Loaded {
    fn service(&self, name: &str) -> ServiceIx {
        self.plan.service(name).expect("a service")
    }

    /// A frame of a service, begun with these inputs.
    pub(crate) fn begin(&self, service: &str, input: Value) -> Box<dyn Frame> {
        let rank = self.service(service);
        let mut frame = self.component.frame(Owner::Service(rank));
        let model = self.plan.component();
        let ty = model.services[rank].input;
        let ty = DataType::new(&self.plan.specification().types, ty).expect("a type");
        let mut record = Record::new(&ty);
        record.merge_json(&input).expect("inputs of the service");
        frame.begin(&record);
        frame
    }

    /// Calls a codel by name; returns the event's name, "" for ok.
    pub(crate) fn call(&self, frame: &mut dyn Frame, codel: &str) -> String {
        let model = self.plan.component();
        let ix = model.codels.find(|one| one.name == codel).expect("a codel");
        let context = match model.codels[ix].kind {
            CodelKind::Fsm { .. } => 0,
            _ => model.tasks.len(),
        };
        match frame.call(ix, context) {
            Returned::Ok => String::new(),
            Returned::Event(id) => self.plan.event_name(id).to_owned(),
            Returned::Unknown | Returned::Failed => frame.returned(),
        }
    }

    /// Runs the codels of a function in order; returns the last event and the outputs.
    pub(crate) fn run(&self, service: &str, input: Value) -> (String, Value) {
        let model = self.plan.component();
        let mut frame = self.begin(service, input);
        let mut event = String::new();
        for codel in &model.services[self.service(service)].codels {
            event = self.call(&mut *frame, &model.codels[*codel].name);
        }
        (event, frame.output().to_json())
    }

    /// Calls a codel of a task.
    pub(crate) fn task(&self, codel: &str) -> String {
        let mut frame = self.component.frame(Owner::Task(TaskIx::new(0)));
        self.call(&mut *frame, codel)
    }

    /// Index of a port.
    pub(crate) fn port(&self, name: &str) -> PortIx {
        let ports = &self.plan.component().ports;
        ports.find(|port| port.name == name).expect("a port")
    }

    /// Type of a port.
    pub(crate) fn port_type(&self, name: &str) -> DataType {
        let ty = self.plan.component().ports[self.port(name)].ty;
        DataType::new(&self.plan.specification().types, ty).expect("a type")
    }
}
