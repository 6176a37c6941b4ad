//! Loads a component from C text, and calls its services.
#![allow(dead_code)]

use std::sync::Arc;

use genom_description::model::{CodelIx, CodelKind, Owner, ServiceIx, Specification};
use genom_host::{Component, Library, LoadErrors};
use genom_runtime::body::{Body, Frame, Returned};
use genom_runtime::plan::Plan;
use serde_json::Value;

use super::Scratch;
use super::generator::{Gen, record};

/// A loaded component, from C text.
pub(crate) struct Loaded {
    pub(crate) component: Component,
    pub(crate) specification: Arc<Specification>,
    pub(crate) plan: Plan,
    _scratch: Scratch,
}

/// Compiles and loads.
pub(crate) fn try_load(make: Gen, c: &str) -> Result<Loaded, LoadErrors> {
    try_load_with(make, |scratch| scratch.library("demo.so", c))
}

/// Loads the library that `compile` makes.
pub(crate) fn try_load_with(
    make: Gen,
    compile: impl FnOnce(&Scratch) -> std::path::PathBuf,
) -> Result<Loaded, LoadErrors> {
    let scratch = Scratch::new();
    let path = compile(&scratch);
    let library = Library::open(&path).expect("a library");
    let specification = Arc::new(make.specification());
    let plan = Plan::new(&specification, 0).expect("a plan");
    let locate = |span: genom_description::model::Span| format!("demo.gen:{}", span.start + 1);
    let component = Component::load(library, &plan, &locate)?;
    Ok(Loaded { component, specification, plan, _scratch: scratch })
}

/// Compiles and loads what must be accepted.
#[track_caller]
pub(crate) fn load(make: Gen, c: &str) -> Loaded {
    try_load(make, c).unwrap_or_else(|errors| panic!("{errors}"))
}

impl Loaded {
    /// A frame of a service, begun with these inputs.
    pub(crate) fn begin(&self, service: ServiceIx, input: Value) -> Box<dyn Frame> {
        let mut frame = self.component.frame(Owner::Service(service));
        let ty = self.specification.components[0].services[service].input;
        frame.begin(&record(&self.specification, ty, input));
        frame
    }

    /// Runs one codel of a service; returns the event's name ("" for ok) and the outputs.
    pub(crate) fn run(&self, service: ServiceIx, codel: CodelIx, input: Value) -> (String, Value) {
        let mut frame = self.begin(service, input);
        let event = self.call(&mut *frame, codel);
        (event, frame.output().to_json())
    }

    /// Calls a codel; returns the event's name, "" for ok.
    pub(crate) fn call(&self, frame: &mut dyn Frame, codel: CodelIx) -> String {
        let model = self.plan.component();
        let context = match model.codels[codel].kind {
            CodelKind::Fsm { .. } => 0,
            _ => model.tasks.len(),
        };
        match frame.call(codel, context) {
            Returned::Ok => String::new(),
            Returned::Event(id) => self.plan.event_name(id).to_owned(),
            Returned::Unknown | Returned::Failed => frame.returned(),
        }
    }
}
