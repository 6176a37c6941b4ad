//! Makes the model: names become indices, and implicit values become explicit.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

use genom_types::{Digester, Kind, Member, ScopedName, TypeId};
use indexmap::{IndexMap, IndexSet};

use super::Checker;
use super::clock::duration;
use super::exclusion::Sharing;
use super::state::{self, BodyId, CodelState, Role, add_throws};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{
    AttributeTarget, Codel, CodelIx, CodelKind, CodelParameter, Component, Dialect, Direction,
    Indexed, Interface, Ix as _, Owner, Parameter, Port, PortDirection, Remote, RemoteIx, Service,
    ServiceIx, ServiceKind, Sink, Source, Specification, Task, TaskIx,
};
use crate::syntax;

/// The structs made of a service's parameters.
#[derive(Clone, Copy)]
struct Records {
    input: TypeId,
    output: TypeId,
    local: TypeId,
}

/// Parts of a service that are moved into the model.
struct Moved {
    validates: Vec<CodelState>,
    codels: Vec<CodelState>,
    parameters: Vec<state::Parameter>,
    locals: Vec<state::Parameter>,
}

/// Structs made so far, by body and index of the service.
type Made = HashMap<(BodyId, usize), Records>;

impl Checker {
    pub(super) fn finish(mut self) -> (Specification, Diagnostics) {
        self.check_forwards();
        // All names are resolved: free the tables before the model is built.
        self.prototypes = HashMap::new();
        self.codel_names = HashSet::new();
        self.scopes.forget_names();
        let mut made = Made::new();
        let mut components = Vec::new();
        let mut interfaces = Vec::new();
        for id in 0..self.bodies.len() {
            self.check_tasks_timing(id);
            if self.bodies[id].interface {
                interfaces.push(self.lower_interface(id));
            } else {
                components.extend(self.lower_component(id, &mut made));
            }
        }
        let types = Arc::new(std::mem::take(&mut self.types));
        for component in &components {
            self.check_async(component);
            if self.diagnostics.errors() == 0 {
                self.check_layouts(&types, component);
            }
            self.warn(component);
            self.warn_unpaused(component);
        }
        let specification = Specification {
            types,
            constants: std::mem::take(&mut self.constants),
            interfaces,
            components,
            masquerades: std::mem::take(&mut self.masquerades),
            // Known to who has the tokens.
            fingerprint: 0,
        };
        self.warn_names(&specification);
        (specification, self.diagnostics)
    }

    fn lower_interface(&self, id: BodyId) -> Interface {
        let body = &self.bodies[id];
        Interface {
            name: body.name.to_string(),
            doc: joined(&body.docs),
            ports: body.ports.keys().map(ToString::to_string).collect(),
            services: body.services.keys().map(ToString::to_string).collect(),
            span: body.span,
        }
    }

    /// `None` when it would exceed the memory limit, which is reported.
    fn lower_component(&mut self, id: BodyId, made: &mut Made) -> Option<Component> {
        let clock_rate = self.clock_rate(id);
        self.place = self.bodies[id].span;
        if !self.reserve(self.complete(id), self.place) {
            return None;
        }
        let mut records: Vec<Records> = Vec::new();
        for rank in 0..self.bodies[id].services.len() {
            records.push(self.records(id, rank, made));
            if self.taken.full {
                return None;
            }
        }
        let remotes = self.lower_remotes(id, made);
        let mut codels = Indexed::default();
        let mut tasks = Vec::new();
        // Moved, not copied: services are most of a large component.
        let mut taken = std::mem::take(&mut self.bodies[id].services);
        let mut task_codels: Vec<Vec<CodelState>> = Vec::new();
        for task in self.bodies[id].tasks.values_mut() {
            task_codels.push(std::mem::take(&mut task.codels));
        }
        let body = &self.bodies[id];
        for (rank, (task, own)) in body.tasks.values().zip(task_codels).enumerate() {
            let owner = Owner::Task(TaskIx::new(rank));
            let ranks = add_codels(&mut codels, own, owner, &remotes);
            let mut throws = body.throws.clone();
            add_throws(&mut throws, &task.throws);
            tasks.push(Task {
                name: task.name.to_string(),
                doc: joined(&task.docs),
                period: task.period.map(|(seconds, _)| duration(seconds)),
                delay: task.delay.map(|(seconds, _)| duration(seconds)).unwrap_or_default(),
                priority: task.priority.map(|(priority, _)| priority),
                real_time: task.real_time.or(body.real_time).is_some(),
                stack: task.stack.or(body.stack).map(|(bytes, _)| bytes),
                codels: ranks,
                throws: throws.into_iter().collect(),
                span: task.span,
            });
        }
        let mut services = Vec::new();
        for (rank, made) in records.iter().enumerate() {
            let owner = Owner::Service(ServiceIx::new(rank));
            let own = taken.get_index_mut(rank).map(|(_, service)| Moved {
                validates: std::mem::take(&mut service.validates),
                codels: std::mem::take(&mut service.codels),
                parameters: std::mem::take(&mut service.parameters),
                locals: std::mem::take(&mut service.locals),
            });
            let (Some(own), Some((_, service))) = (own, taken.get_index(rank)) else { continue };
            let mut service = self.lower_service(id, service, *made, &taken);
            service.validates = add_codels(&mut codels, own.validates, owner, &remotes);
            service.codels = add_codels(&mut codels, own.codels, owner, &remotes);
            service.parameters = own.parameters.into_iter().map(lower_parameter).collect();
            service.locals = own.locals.into_iter().map(lower_parameter).collect();
            services.push(service);
        }
        let all = tasks.iter().map(|task| &task.throws);
        let all = all.chain(services.iter().map(|service| &service.throws)).flatten();
        let throws: IndexSet<TypeId> = body.throws.iter().chain(all).copied().collect();
        let mut component = Component {
            name: body.name.to_string(),
            dialect: body.dialect,
            doc: joined(&body.docs),
            version: body.version.as_ref().map_or("0", |(text, _)| text).to_owned(),
            lang: body.lang.as_ref().map_or("c", |(text, _)| text).to_owned(),
            email: body.email.as_ref().map(|(text, _)| text.clone()),
            requires: body.requires.clone(),
            codels_requires: body.codels_requires.clone(),
            clock_rate,
            ids: body.ids,
            tasks: tasks.into_iter().collect(),
            ports: body.ports.iter().map(|(name, port)| lower_port(name, port)).collect(),
            remotes,
            services: services.into_iter().collect(),
            codels,
            states: body.states.keys().map(ToString::to_string).collect(),
            sinks: body
                .sinks
                .iter()
                .map(|(state, span)| Sink {
                    name: self.state_name(id, *state).to_owned(),
                    state: *state,
                    span: *span,
                })
                .collect(),
            throws: throws.into_iter().collect(),
            exclusion: Vec::new(),
            digest: String::new(),
            span: body.span,
        };
        if !complete(&mut component) {
            let message =
                format!("codels of `{}` share more data than can be told apart", component.name);
            self.push(
                Diagnostic::error("E0725", component.span, message)
                    .help("name the members of the IDS that each codel uses, not the whole of it"),
            );
            return None;
        }
        self.digests(&mut component);
        Some(component)
    }

    fn lower_service(
        &self,
        id: BodyId,
        service: &state::Service,
        records: Records,
        all: &IndexMap<Rc<str>, state::Service>,
    ) -> Service {
        let body = &self.bodies[id];
        let mut throws = body.throws.clone();
        let task = service.task.map(|(task, _)| task);
        if let Some((_, task)) = task.and_then(|task| body.tasks.get_index(task)) {
            add_throws(&mut throws, &task.throws);
        }
        add_throws(&mut throws, &service.throws);
        let ranks = |names: &[syntax::Name]| -> Vec<ServiceIx> {
            if names.iter().any(|name| &*name.text == "all") {
                return (0..all.len()).map(ServiceIx::new).collect();
            }
            let found = names.iter().filter_map(|name| all.get_index_of(&name.text));
            found.map(ServiceIx::new).collect()
        };
        let ordered = |given: &state::Given<Vec<syntax::Name>>| {
            given.as_ref().map(|(names, _)| ranks(names)).unwrap_or_default()
        };
        Service {
            kind: lower_kind(service.kind),
            name: service.name.to_string(),
            doc: joined(&service.docs),
            parameters: Vec::new(),
            locals: Vec::new(),
            input: records.input,
            output: records.output,
            local: records.local,
            task: task.map(TaskIx::new),
            interrupts: ranks(&service.interrupts),
            before: ordered(&service.before),
            after: ordered(&service.after),
            validates: Vec::new(),
            codels: Vec::new(),
            throws: throws.into_iter().collect(),
            standard: service.standard,
            through_ids: service.through_ids,
            digest: String::new(),
            call_digest: String::new(),
            span: service.span,
        }
    }

    fn lower_remotes(&mut self, id: BodyId, made: &mut Made) -> Indexed<RemoteIx, Remote> {
        let remotes: Vec<_> = self.bodies[id]
            .remotes
            .iter()
            .map(|(name, remote)| (name.to_string(), remote.clone()))
            .collect();
        let mut list = Indexed::default();
        for (name, remote) in remotes {
            let records = self.records(remote.interface, remote.service, made);
            let interface = &self.bodies[remote.interface];
            let Some((_, service)) = interface.services.get_index(remote.service) else { continue };
            let mut throws = self.bodies[id].throws.clone();
            if let Some((_, task)) =
                service.task.and_then(|(task, _)| interface.tasks.get_index(task))
            {
                add_throws(&mut throws, &task.throws);
            }
            add_throws(&mut throws, &service.throws);
            list.push(Remote {
                name,
                interface: interface.name.to_string(),
                kind: lower_kind(service.kind),
                parameters: service.parameters.iter().cloned().map(lower_parameter).collect(),
                input: records.input,
                output: records.output,
                throws: throws.into_iter().collect(),
                digest: String::new(),
                span: remote.span,
            });
        }
        list
    }

    /// The structs of a service, named `::component::service::input` and so on.
    fn records(&mut self, id: BodyId, rank: usize, made: &mut Made) -> Records {
        if let Some(known) = made.get(&(id, rank)) {
            return *known;
        }
        let body = &self.bodies[id];
        let scope = self.scopes.full_name(body.scope);
        let mut lists = [Vec::new(), Vec::new(), Vec::new()];
        let mut name = scope.clone();
        if let Some((_, service)) = body.services.get_index(rank) {
            name = scope.join(&service.name);
            for p in &service.parameters {
                let member = Member { name: p.name.to_string(), ty: p.ty };
                if p.direction != Direction::Out {
                    lists[0].push(member.clone());
                }
                if p.direction != Direction::In {
                    lists[1].push(member);
                }
            }
            let locals = service.locals.iter();
            lists[2] = locals.map(|p| Member { name: p.name.to_string(), ty: p.ty }).collect();
        }
        let [input, output, local] = lists;
        let mut add = |what: &str, members| {
            let name: ScopedName = name.join(what);
            self.add_type(Kind::Struct { name, members }, None)
        };
        let records = Records {
            input: add("input", input),
            output: add("output", output),
            local: add("local", local),
        };
        made.insert((id, rank), records);
        records
    }

    // genom3.md 4.9.
    fn digests(&self, component: &mut Component) {
        let mut whole = Digester::default();
        for port in &component.ports {
            let kind = if port.multiple { "multiple" } else { "simple" };
            whole.text("port").text(kind).text(&port.name).ty(&self.types, port.ty);
        }
        let signature = |to: &mut Digester,
                         parameters: &[Parameter],
                         locals: &[Parameter],
                         throws: &[TypeId]| {
            for parameter in parameters {
                let direction = match parameter.direction {
                    Direction::In => "in",
                    Direction::Out => "out",
                    Direction::InOut => "inout",
                };
                to.text(direction).ty(&self.types, parameter.ty);
            }
            for local in locals {
                to.text("local").ty(&self.types, local.ty);
            }
            for exception in throws {
                to.ty(&self.types, *exception);
            }
        };
        for service in &mut component.services {
            let kind = match service.kind {
                ServiceKind::Attribute => "attribute",
                ServiceKind::Function => "function",
                ServiceKind::Activity => "activity",
            };
            whole.text(kind).text(&service.name);
            signature(&mut whole, &service.parameters, &service.locals, &service.throws);
            let mut own = Digester::default();
            signature(&mut own, &service.parameters, &service.locals, &service.throws);
            service.digest = own.finish();
            let mut own = Digester::default();
            signature(&mut own, &service.parameters, &[], &service.throws);
            service.call_digest = own.finish();
        }
        for remote in &mut component.remotes {
            let mut own = Digester::default();
            signature(&mut own, &remote.parameters, &[], &remote.throws);
            remote.digest = own.finish();
        }
        component.digest = whole.finish();
    }
}

/// Adds what is computed from codels and services: exclusion, and the interruptions of the papers'
/// dialects. False when the limit is exceeded.
fn complete(component: &mut Component) -> bool {
    if component.dialect != Dialect::Current {
        // dialects.md A: a service interrupts those it is incompatible with, unless it lists others.
        let Some(lists) = Sharing::new(component).incompatible() else { return false };
        for (service, list) in component.services.iter_mut().zip(lists) {
            if service.interrupts.is_empty() && service.kind == ServiceKind::Activity {
                service.interrupts = list;
            }
        }
    }
    let Some(table) = Sharing::new(component).table() else { return false };
    component.exclusion = table;
    true
}

fn add_codels(
    codels: &mut Indexed<CodelIx, Codel>,
    from: Vec<CodelState>,
    owner: Owner,
    remotes: &Indexed<RemoteIx, Remote>,
) -> Vec<CodelIx> {
    let add = |codel: CodelState| {
        let kind = match codel.role {
            Role::Validate => CodelKind::Validate,
            Role::Simple => CodelKind::Simple,
            Role::Machine => CodelKind::Fsm { triggers: codel.triggers, yields: codel.yields },
        };
        let parameters = codel.parameters.into_iter().map(|p| CodelParameter {
            name: p.name.to_string(),
            direction: p.direction,
            ty: match &p.source {
                Source::Remote(rank) => remotes.get(*rank).map_or(p.ty, |remote| remote.input),
                _ => p.ty,
            },
            source: p.source,
            span: p.span,
        });
        codels.push(Codel {
            name: codel.syntax.name.text.to_string(),
            owner,
            kind,
            asynchronous: codel.syntax.asynchronous,
            parameters: parameters.collect(),
            wcet: codel.wcet.map(duration),
            span: codel.syntax.name.span,
        })
    };
    from.into_iter().map(add).collect()
}

fn lower_parameter(parameter: state::Parameter) -> Parameter {
    Parameter {
        name: parameter.name.to_string(),
        direction: parameter.direction,
        ty: parameter.ty,
        default: parameter.default,
        target: parameter.target.map(|t| AttributeTarget { path: t.path }),
        span: parameter.span,
    }
}

fn lower_port(name: &str, port: &state::PortState) -> Port {
    Port {
        name: name.to_string(),
        direction: if port.out { PortDirection::Out } else { PortDirection::In },
        multiple: port.multiple,
        interface: port.interface.as_ref().map(ToString::to_string),
        ty: port.ty,
        doc: joined(&port.docs),
        span: port.span,
    }
}

fn joined(docs: &[String]) -> Option<String> {
    (!docs.is_empty()).then(|| docs.join("\n"))
}

fn lower_kind(kind: syntax::ServiceKind) -> ServiceKind {
    match kind {
        syntax::ServiceKind::Attribute => ServiceKind::Attribute,
        syntax::ServiceKind::Activity => ServiceKind::Activity,
        syntax::ServiceKind::Function | syntax::ServiceKind::Service => ServiceKind::Function,
    }
}
