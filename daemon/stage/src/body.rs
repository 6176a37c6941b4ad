//! A body without library: its codels return when they are told, and what they are told.

use std::sync::Arc;

use genom_description::model::{CodelIx, Owner, PortIx, RemoteIx};
use genom_middleware::{Publisher, Subscription};
use genom_runtime::body::{Body, EventId, Frame, Opener, RemoteCall, Returned};
use genom_runtime::plan::{Plan, Transition};
use genom_types::{DataType, Kind, LayoutError, Record, TypeTable};
use serde_json::Value;

use crate::theatre::Theatre;

/// A body without library.
#[derive(Clone)]
pub(crate) struct Scripted {
    plan: Arc<Plan>,
    theatre: Arc<Theatre>,
    /// Of outputs that nobody reads.
    nothing: DataType,
}

impl Scripted {
    pub(crate) fn new(plan: &Arc<Plan>, theatre: &Arc<Theatre>) -> Result<Self, LayoutError> {
        let mut table = TypeTable::default();
        let octet = table.add(Kind::Octet);
        let nothing = DataType::new(&Arc::new(table), octet)?;
        Ok(Self { plan: Arc::clone(plan), theatre: Arc::clone(theatre), nothing })
    }
}

impl Body for Scripted {
    fn frame(&self, owner: Owner) -> Box<dyn Frame> {
        let output = match owner {
            Owner::Service(service) => &self.plan.services()[service].output,
            Owner::Task(_) => &self.nothing,
        };
        Box::new(ScriptedFrame { body: self.clone(), output: Record::new(output) })
    }

    fn bind_out(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Publisher>>) {}
    fn bind_in(&self, _: PortIx, _: Option<&str>, _: Option<Box<dyn Subscription>>) {}
    fn bind_remote(&self, _: RemoteIx, _: Option<Box<dyn RemoteCall>>) {}
    fn set_opener(&self, _: Box<dyn Opener>) {}

    fn port_value(&self, _: PortIx, _: Option<&str>) -> Option<Value> {
        None
    }

    fn write_port(&self, _: PortIx, _: &Record) {}
}

struct ScriptedFrame {
    body: Scripted,
    output: Record,
}

impl ScriptedFrame {
    /// What ends an activity: nothing is played any more.
    fn end(&self, codel: CodelIx) -> Returned {
        let mut table = self.body.plan.transitions(codel).iter().zip(0u16..);
        match table.find(|(to, _)| **to == Transition::End) {
            Some((_, event)) => Returned::Event(EventId(event)),
            None => Returned::Ok,
        }
    }
}

impl Frame for ScriptedFrame {
    fn begin(&mut self, _: &Record) {}
    fn store(&mut self) {}
    fn fetch(&mut self) {}

    fn call(&mut self, codel: CodelIx, context: usize) -> Returned {
        let returned = self.body.theatre.codel(codel, context);
        returned.unwrap_or_else(|| self.end(codel))
    }

    fn returned(&self) -> String {
        String::new()
    }

    fn detail(&self) -> Option<Value> {
        None
    }

    fn output(&self) -> &Record {
        &self.output
    }
}
