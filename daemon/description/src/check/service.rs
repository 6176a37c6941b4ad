//! Attributes, functions, activities, and services of the papers' dialects (genom3.md 3.6).

use std::collections::HashMap;
use std::rc::Rc;

use super::Checker;
use super::attribute::direction;
use super::room;
use super::state::{BodyId, Parameter, Role, Service, add_throws};
use crate::diagnostic::Diagnostic;
use crate::model::{Dialect, Direction, Span};
use crate::syntax::{
    self, Declarator, Name, Property, PropertyKind, ServiceKind, ServiceParameters, TypeSpec,
    Variable, VariableParameter,
};

impl Checker {
    pub(super) fn service(&mut self, id: BodyId, dcl: &syntax::Service) {
        let name = &dcl.name;
        let papers = self.bodies[id].dialect != Dialect::Current;
        if dcl.kind == ServiceKind::Service && !papers {
            let message = "`service` belongs to the papers' syntax";
            self.push(
                Diagnostic::error("E0103", dcl.span, message)
                    .help("write `attribute`, `function` or `activity`"),
            );
            self.lost.insert(name.text.clone());
            return;
        }
        let kind = kind_of(dcl);
        let Some(mut service) = self.start_service(id, kind, name) else {
            self.lost.insert(name.text.clone());
            return;
        };
        let reopened = service.is_some();
        let count = self.diagnostics.errors();
        let parameters = self.parameters(id, dcl);
        let refused = self.diagnostics.errors() > count;
        let mut service = match service.take() {
            Some(mut known) => {
                // A reopened service has to repeat its parameters.
                if refused || !self.same_parameters(&mut known, &parameters, name.span) {
                    known.broken = true;
                    self.bodies[id].services.insert(known.name.clone(), known);
                    return;
                }
                known
            }
            None => {
                let mut fresh = Service::new(kind, name);
                fresh.standard = self.bodies[id].interface && &*self.bodies[id].name == "genom";
                fresh.through_ids = papers && kind != ServiceKind::Attribute;
                fresh.parameters = parameters;
                fresh
            }
        };
        service.broken |= refused && !reopened;
        for property in &dcl.properties {
            self.service_property(id, &mut service, property);
        }
        self.reserve(room::service(&service), name.span);
        let (rank, _) = self.bodies[id].services.insert_full(name.text.clone(), service);
        self.bodies[id].touched_services.insert(rank);
    }

    /// The service to continue with: `Some(None)` for a new one, `None` if it is refused.
    // genom3.md 3.6 S1 to S3.
    pub(super) fn start_service(
        &mut self,
        id: BodyId,
        kind: ServiceKind,
        name: &Name,
    ) -> Option<Option<Service>> {
        if &*name.text == "all" {
            let message = "`all` stands for every service, it cannot name one";
            self.push(Diagnostic::error("E0601", name.span, message));
            return None;
        }
        let body = &self.bodies[id];
        let other = body
            .ports
            .get(&name.text)
            .map(|port| ("a port", port.span))
            .or_else(|| body.remotes.get(&name.text).map(|remote| ("a remote", remote.span)));
        if let Some((what, span)) = other {
            let message = format!("`{}` is {what}, it cannot be a service too", name.text);
            self.push(Diagnostic::error("E0602", name.span, message).note(span, "declared here"));
            return None;
        }
        let Some(known) = self.bodies[id].services.get_mut(&name.text) else { return Some(None) };
        if known.kind != kind {
            let message = format!(
                "`{}` is {}, it cannot be {} too",
                name.text,
                article(known.kind),
                article(kind)
            );
            let (span, standard) = (known.span, known.standard);
            let mut error =
                Diagnostic::error("E0603", name.span, message).note(span, "declared here");
            if standard {
                error = error.help("this service is part of every component: choose another name");
            }
            self.push(error);
            return None;
        }
        let placeholder = Service::new(kind, name);
        Some(Some(std::mem::replace(known, placeholder)))
    }

    // genom3.md 3.6 S12, S15.
    fn parameters(&mut self, id: BodyId, dcl: &syntax::Service) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        match &dcl.parameters {
            ServiceParameters::Variables(list) => {
                for parameter in list {
                    parameters.extend(self.attribute_parameter(id, parameter));
                }
                if dcl.kind == ServiceKind::Service {
                    for parameter in paper_parameters(&dcl.properties) {
                        parameters.extend(self.attribute_parameter(id, &parameter));
                    }
                }
            }
            ServiceParameters::Typed(list) => {
                for parameter in list {
                    let name = &parameter.declarator.name;
                    let Some(ty) = self.declarator_type(&parameter.ty, &parameter.declarator)
                    else {
                        continue;
                    };
                    let default =
                        parameter.initializer.as_ref().and_then(|init| self.initial(init, ty));
                    parameters.push(Parameter {
                        name: name.text.clone(),
                        direction: direction(parameter.direction),
                        ty,
                        default,
                        target: None,
                        span: name.span,
                    });
                }
            }
        }
        for parameter in &parameters {
            if self.contains_native(parameter.ty) {
                let message = format!(
                    "parameter `{}` of a service cannot hold a native type",
                    parameter.name
                );
                self.push(Diagnostic::error("E0612", parameter.span, message));
            }
        }
        let mut seen: HashMap<Rc<str>, Span> = HashMap::new();
        parameters.retain(|parameter| match seen.get(&parameter.name) {
            None => {
                seen.insert(parameter.name.clone(), parameter.span);
                true
            }
            Some(first) => {
                self.duplicate_parameter(&parameter.name, parameter.span, *first);
                false
            }
        });
        parameters
    }

    fn declarator_type(
        &mut self,
        spec: &TypeSpec,
        declarator: &Declarator,
    ) -> Option<genom_types::TypeId> {
        let ty = self.type_spec(spec).and_then(|ty| self.declared(ty, declarator));
        if ty.is_none() {
            self.lost.insert(declarator.name.text.clone());
        }
        ty
    }

    pub(super) fn duplicate_parameter(&mut self, name: &str, span: Span, first: Span) {
        let message = format!("parameter `{name}` is declared twice");
        self.push(Diagnostic::error("E0615", span, message).note(first, "declared here"));
    }

    /// Compares the parameters of a service with those it was first declared with.
    // genom3.md 3.6 S4 to S7.
    pub(super) fn same_parameters(
        &mut self,
        known: &mut Service,
        fresh: &[Parameter],
        span: Span,
    ) -> bool {
        for (old, new) in known.parameters.iter().zip(fresh) {
            let (code, message) = if old.name != new.name {
                let message = format!("parameter `{}` was called `{}` before", new.name, old.name);
                ("E0604", message)
            } else if old.direction != new.direction || !self.types.equal(old.ty, new.ty) {
                let message =
                    format!("parameter `{}` had another direction or type before", new.name);
                ("E0605", message)
            } else {
                continue;
            };
            let error =
                Diagnostic::error(code, new.span, message).note(old.span, "first declared here");
            self.push(error);
            return false;
        }
        let first = known.span;
        if let Some(extra) = fresh.get(known.parameters.len()) {
            let message = format!("`{}` had no parameter `{}` before", known.name, extra.name);
            self.push(
                Diagnostic::error("E0606", extra.span, message).note(first, "first declared here"),
            );
            return false;
        }
        if let Some(missing) = known.parameters.get(fresh.len()) {
            let message = format!("parameter `{}` of `{}` is missing", missing.name, known.name);
            let error = Diagnostic::error("E0607", span, message)
                .note(missing.span, "first declared here")
                .help("a service opened again repeats all its parameters");
            self.push(error);
            return false;
        }
        true
    }

    // genom3.md 3.5 P5, P13, P16; 3.6 S8 to S10, S17.
    fn service_property(&mut self, id: BodyId, service: &mut Service, property: &Property) {
        use PropertyKind as K;
        let keyword = &property.keyword;
        let what = article(service.kind);
        self.check_colon(id, property);
        match &property.kind {
            K::Doc(text) => service.docs.push(text.text.clone()),
            K::Task(name) => {
                if service.kind != ServiceKind::Activity {
                    let message = format!("`{}` is {what}, it runs in no task", service.name);
                    self.push(Diagnostic::error("E0608", keyword.span, message));
                    return;
                }
                match self.bodies[id].tasks.get_index_of(&name.text) {
                    Some(task) => self.give(&mut service.task, task, keyword),
                    None => self.unknown_task(id, service, name),
                }
            }
            K::Interrupts(names) => {
                let names = self.distinct(names);
                if service.interrupts.is_empty() {
                    service.interrupts = names;
                    return;
                }
                for name in names {
                    if !service.interrupts.iter().any(|known| known.text == name.text) {
                        service.interrupts.push(name);
                    }
                }
            }
            K::Before(names) => {
                let names = self.distinct(names);
                self.give(&mut service.before, names, keyword);
            }
            K::After(names) => {
                let names = self.distinct(names);
                self.give(&mut service.after, names, keyword);
            }
            K::Throws(list) => {
                let fresh = self.throws(id, list);
                add_throws(&mut service.throws, &fresh);
            }
            K::Validate(codel) => {
                let all = service.validates.iter().chain(&service.codels);
                if self.is_new_codel(codel, all)
                    && let Some(codel) = self.codel(id, Some(service), codel, Role::Validate, None)
                {
                    service.validates.push(codel);
                }
            }
            K::Codel(codel) => {
                let role = match (&codel.machine, service.kind) {
                    (None, ServiceKind::Activity) => {
                        let message = format!(
                            "activity `{}` runs a state machine: `{}` has no state",
                            service.name, codel.name.text
                        );
                        self.push(Diagnostic::error("E0609", codel.name.span, message).help(
                            format!("write `codel<STATE> {}(...) yield ...`", codel.name.text),
                        ));
                        service.broken = true;
                        return;
                    }
                    (Some(_), ServiceKind::Attribute | ServiceKind::Function) => {
                        let message =
                            format!("`{}` is {what}, it has no state machine", service.name);
                        self.push(Diagnostic::error("E0610", codel.name.span, message));
                        return;
                    }
                    (None, _) => Role::Simple,
                    (Some(_), _) => Role::Machine,
                };
                let all = service.validates.iter().chain(&service.codels);
                if self.is_new_codel(codel, all) {
                    match self.codel(id, Some(service), codel, role, None) {
                        Some(codel) => service.codels.push(codel),
                        None => service.broken = true,
                    }
                }
            }
            K::Local(..) if service.kind == ServiceKind::Attribute => {
                let message = "an attribute has no local variables";
                self.push(Diagnostic::error("E0617", keyword.span, message));
            }
            K::Local(spec, declarators) => {
                let ty = self.type_spec(spec);
                for declarator in declarators {
                    match ty.and_then(|ty| self.declared(ty, declarator)) {
                        Some(ty) => self.local(service, &declarator.name, ty),
                        None => _ = self.lost.insert(declarator.name.text.clone()),
                    }
                }
            }
            // Read with the parameters.
            K::Input(_) | K::Output(_) if self.bodies[id].dialect != Dialect::Current => {}
            _ => {
                let message = format!("`{}` is no property of services", keyword.text);
                self.push(Diagnostic::error("E0505", keyword.span, message));
            }
        }
    }

    fn unknown_task(&mut self, id: BodyId, service: &mut Service, name: &Name) {
        service.broken = true;
        if self.lost.contains(&name.text) {
            return;
        }
        let help = self
            .suggest(&name.text, |this| this.bodies[id].tasks.keys().map(|name| &**name).collect());
        let message = format!("unknown task `{}`", name.text);
        let mut error = Diagnostic::error("E0513", name.span, message);
        error.help = help.or(Some("a task is declared before the services it runs".to_owned()));
        self.push(error);
    }

    fn local(&mut self, service: &mut Service, name: &Name, ty: genom_types::TypeId) {
        if let Some(other) = service.parameters.iter().find(|p| p.name == name.text) {
            self.duplicate_parameter(&name.text, name.span, other.span);
            return;
        }
        if let Some(other) = service.locals.iter().find(|p| p.name == name.text) {
            let span = other.span;
            if !self.types.equal(other.ty, ty) {
                let message = format!("local variable `{}` had another type before", name.text);
                self.push(
                    Diagnostic::error("E0605", name.span, message)
                        .note(span, "first declared here"),
                );
            } else {
                self.duplicate_parameter(&name.text, name.span, span);
            }
            return;
        }
        service.locals.push(Parameter {
            name: name.text.clone(),
            direction: Direction::InOut,
            ty,
            default: None,
            target: None,
            span: name.span,
        });
    }

    // genom3.md 3.5 P16.
    fn distinct(&mut self, names: &[Name]) -> Vec<Name> {
        let mut seen: HashMap<&str, Span> = HashMap::new();
        let mut kept = Vec::new();
        for name in names {
            if let Some(first) = seen.get(&*name.text) {
                let message = format!("`{}` is listed twice", name.text);
                let error =
                    Diagnostic::error("E0516", name.span, message).note(*first, "listed here");
                self.push(error);
                continue;
            }
            seen.insert(&name.text, name.span);
            kept.push(name.clone());
        }
        kept
    }

    /// `interrupts`, `before` and `after` name services of the component.
    // genom3.md 3.5 P17.
    pub(super) fn check_named_services(&mut self, id: BodyId, rank: usize) {
        let Some((_, service)) = self.bodies[id].services.get_index(rank) else { return };
        let ordered = [&service.before, &service.after];
        let names = service
            .interrupts
            .iter()
            .chain(ordered.into_iter().flatten().flat_map(|(names, _)| names));
        let unknown: Vec<Name> = names
            .filter(|name| &*name.text != "all")
            .filter(|name| !self.bodies[id].services.contains_key(&name.text))
            .filter(|name| !self.lost.contains(&name.text))
            .cloned()
            .collect();
        for name in unknown {
            let help = self.suggest(&name.text, |this| {
                this.bodies[id].services.keys().map(|name| &**name).collect()
            });
            let message = format!("no such service `{}`", name.text);
            let mut error = Diagnostic::error("E0517", name.span, message);
            error.help = help;
            self.push(error);
        }
    }
}

/// Kind of a service; in the papers' dialects it follows from its content (dialects.md B).
fn kind_of(dcl: &syntax::Service) -> ServiceKind {
    if dcl.kind != ServiceKind::Service {
        return dcl.kind;
    }
    let mut simple = false;
    for property in &dcl.properties {
        match &property.kind {
            PropertyKind::Task(_) => return ServiceKind::Activity,
            PropertyKind::Codel(codel) if codel.machine.is_some() => return ServiceKind::Activity,
            PropertyKind::Codel(_) => simple = true,
            _ => {}
        }
    }
    if simple { ServiceKind::Function } else { ServiceKind::Attribute }
}

/// Makes parameters of `input:` and `output:`; those in both are `inout` (dialects.md A).
fn paper_parameters(properties: &[Property]) -> Vec<VariableParameter> {
    let mut list: Vec<VariableParameter> = Vec::new();
    let mut add = |variable: &Variable, way: syntax::Direction| {
        let span = variable.root.span.to(variable.last().span);
        let text = |v: &VariableParameter| v.variable.as_ref().map(|v| v.last().text.clone());
        let known =
            list.iter_mut().find(|known| text(known).as_ref() == Some(&variable.last().text));
        match known {
            Some(known) if known.direction != way => known.direction = syntax::Direction::InOut,
            _ => list.push(VariableParameter {
                direction: way,
                variable: Some(variable.clone()),
                rename: None,
                initializer: None,
                span,
            }),
        }
    };
    for property in properties {
        match &property.kind {
            PropertyKind::Input(names) => {
                names.iter().for_each(|v| add(v, syntax::Direction::In));
            }
            PropertyKind::Output(names) => {
                names.iter().for_each(|v| add(v, syntax::Direction::Out));
            }
            _ => {}
        }
    }
    list
}

pub(super) fn article(kind: ServiceKind) -> &'static str {
    match kind {
        ServiceKind::Attribute => "an attribute",
        ServiceKind::Function => "a function",
        ServiceKind::Activity => "an activity",
        ServiceKind::Service => "a service",
    }
}
