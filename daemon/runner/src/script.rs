//! What the interpreter has to know of a script: the codels that it is to have, and the memory that
//! they work on.

use std::time::Duration;

use genom_description::c_names::records;
use genom_description::model::{
    Codel, CodelKind, Component, Direction, Ix as _, Owner, PortDirection, Remote, Source, Span,
    Specification, StateIx,
};
use genom_host::Contents;
use genom_runtime::plan::Plan;
use genom_types::{DataType, Kind, Outline, TypeId};
use serde_json::{Value, json};

/// A request to load a script, as JSON.
///
/// # Errors
/// The script is not UTF-8, or the component has what codels in Python cannot use.
pub(crate) fn request(
    script: &Contents,
    plan: &Plan,
    within: Duration,
    locate: &dyn Fn(Span) -> String,
) -> Result<Vec<u8>, Vec<String>> {
    let text = std::str::from_utf8(&script.bytes)
        .map_err(|why| vec![format!("it is not text in UTF-8: {why}")])?;
    let (model, specification) = (plan.component(), plan.specification().as_ref());
    let mut writer =
        Writer { specification, model, locate, outline: Outline::default(), wrong: Vec::new() };
    let own = model.codels.iter().filter(|codel| !is_standard(model, codel));
    let codels: Vec<Value> = own.map(|codel| writer.codel(codel)).collect();
    let ports: Vec<Value> = model
        .ports
        .iter()
        .map(|port| {
            json!({
                "name": port.name,
                "out": port.direction == PortDirection::Out,
                "multiple": port.multiple,
                "type": writer.lay_out(port.ty, port.span),
            })
        })
        .collect();
    let remotes: Vec<Value> = model.remotes.iter().map(|remote| writer.remote(remote)).collect();
    let (exceptions, declared) = (writer.exceptions(), writer.declared());
    if !writer.wrong.is_empty() {
        return Err(writer.wrong);
    }
    let constants: Vec<Value> = specification
        .constants
        .iter()
        .map(|one| json!({ "name": one.name.segments(), "value": one.value }))
        .collect();
    let request = json!({
        "path": std::path::absolute(&script.path).unwrap_or_else(|_| script.path.clone()),
        "text": text,
        "seconds": within.as_secs_f64(),
        "component": model.name,
        "place": locate(model.span),
        "codels": codels,
        "ports": ports,
        "remotes": remotes,
        "exceptions": exceptions,
        "declared": declared,
        "constants": constants,
        "types": writer.outline.types(),
    });
    serde_json::to_vec(&request).map_err(|why| vec![why.to_string()])
}

struct Writer<'a> {
    specification: &'a Specification,
    model: &'a Component,
    locate: &'a dyn Fn(Span) -> String,
    outline: Outline,
    wrong: Vec<String>,
}

impl Writer<'_> {
    /// Index of a type; a type without a layout is an error that the host tells.
    fn lay_out(&mut self, ty: TypeId, span: Span) -> Option<usize> {
        match DataType::new(&self.specification.types, ty) {
            Ok(ty) => Some(self.outline.place(ty)),
            Err(why) => {
                self.wrong.push(format!("{}: {why}", (self.locate)(span)));
                None
            }
        }
    }

    fn codel(&mut self, codel: &Codel) -> Value {
        let state = |state: StateIx| self.model.states.get(state).map_or("", String::as_str);
        let owner = match codel.owner {
            Owner::Service(service) => {
                let service = self.model.services.get(service);
                format!("service {}", service.map_or("", |service| &service.name))
            }
            Owner::Task(task) => {
                format!("task {}", self.model.tasks.get(task).map_or("", |task| &task.name))
            }
        };
        let yields = match &codel.kind {
            CodelKind::Fsm { yields, .. } => {
                let name = |pause, state| format!("{}{state}", if pause { "pause::" } else { "" });
                Some(yields.iter().map(|to| name(to.pause, state(to.state))).collect::<Vec<_>>())
            }
            CodelKind::Validate | CodelKind::Simple => None,
        };
        let parameters: Vec<Value> = codel
            .parameters
            .iter()
            .map(|parameter| {
                let (from, rank) = match parameter.source {
                    Source::Port(port) => ("port", Some(port.index())),
                    Source::Remote(remote) => ("remote", Some(remote.index())),
                    Source::Ids { .. } | Source::Parameter { .. } | Source::Local { .. } => {
                        ("data", None)
                    }
                };
                json!({
                    "name": parameter.name,
                    "place": (self.locate)(parameter.span),
                    "from": from,
                    "rank": rank,
                    "direction": direction(parameter.direction),
                    "type": self.lay_out(parameter.ty, parameter.span),
                })
            })
            .collect();
        json!({
            "name": codel.name,
            "place": (self.locate)(codel.span),
            "owner": owner,
            "yields": yields,
            "parameters": parameters,
        })
    }

    fn remote(&mut self, remote: &Remote) -> Value {
        let parameters = remote.parameters.iter().map(|parameter| {
            json!({
                "name": parameter.name,
                "direction": direction(parameter.direction),
                "type": self.lay_out(parameter.ty, parameter.span),
            })
        });
        json!({ "name": remote.name, "parameters": parameters.collect::<Vec<_>>() })
    }

    /// All exceptions that codels can raise.
    fn exceptions(&mut self) -> Vec<Value> {
        let types = &self.specification.types;
        let all: Vec<_> = types
            .iter()
            .filter_map(|(id, kind)| match kind {
                Kind::Exception { name, members } => Some((id, name.clone(), members.is_empty())),
                _ => None,
            })
            .collect();
        let exceptions = all.into_iter().map(|(id, name, empty)| {
            // One of another component may have an incomplete type: it has no detail here.
            let detail = DataType::new(types, id).ok().filter(|_| !empty);
            let place = detail.map(|detail| self.outline.place(detail));
            json!({ "event": name.to_string(), "name": name.segments(), "type": place })
        });
        exceptions.collect()
    }

    /// The types that the description declares, by name.
    fn declared(&mut self) -> Vec<Value> {
        let hidden = records(self.specification);
        let types = &self.specification.types;
        let named = types.iter().filter(|(id, _)| !hidden.contains(id));
        let named: Vec<_> = named
            .filter(|(_, kind)| {
                !matches!(kind, Kind::Exception { .. } | Kind::Forward { .. } | Kind::Native { .. })
            })
            .filter_map(|(id, kind)| Some((id, kind.name()?.clone())))
            .collect();
        let named = named.into_iter().filter_map(|(id, name)| {
            let ty = DataType::new(types, id).ok()?;
            Some(json!({ "name": name.segments(), "type": self.outline.place(ty) }))
        });
        named.collect()
    }
}

fn direction(direction: Direction) -> &'static str {
    match direction {
        Direction::In => "in",
        Direction::Out => "out",
        Direction::InOut => "inout",
    }
}

/// Whether the runtime supplies it.
fn is_standard(model: &Component, codel: &Codel) -> bool {
    match codel.owner {
        Owner::Service(service) => model.services.get(service).is_some_and(|one| one.standard),
        Owner::Task(_) => false,
    }
}
