//! `provides`, `extends` and `uses`: merges an interface into another body (genom3.md 4.6).

use super::Checker;
use super::scope::Entity;
use super::state::{
    BodyId, CodelState, Given, Parameter, PortState, Remote, Service, Target, Task, add_new,
    add_throws,
};
use crate::diagnostic::Diagnostic;
use crate::model::Span;
use crate::syntax::Name;

impl Checker {
    /// Merges interface `from` into `id`; with `flip`, as `uses` does.
    pub(super) fn merge(&mut self, id: BodyId, from: BodyId, flip: bool, place: Span) {
        if !self.reserve(self.handed_on(from), place) {
            return;
        }
        let count = self.diagnostics.len();
        self.merge_properties(id, from);
        self.merge_ids(id, from);
        for (_, task) in self.bodies[from].tasks.clone() {
            self.merge_task(id, task);
        }
        for (name, port) in self.bodies[from].ports.clone() {
            self.merge_port(id, &name, port, flip);
        }
        let services: Vec<Service> = self.bodies[from].services.values().cloned().collect();
        for (rank, service) in services.into_iter().enumerate() {
            if flip {
                let span = service.span;
                let remote = Remote { interface: from, service: rank, span };
                self.add_remote(id, &Name { text: service.name, span }, remote);
            } else {
                self.merge_service(id, service);
            }
        }
        for (name, remote) in self.bodies[from].remotes.clone() {
            let span = remote.span;
            self.add_remote(id, &Name { text: name, span }, remote);
        }
        let body = self.bodies[id].name.clone();
        for diagnostic in self.diagnostics.iter_mut().skip(count) {
            diagnostic.notes.push((place, format!("brought into `{body}` here")));
        }
    }

    // genom3.md 3.4 I5.
    fn merge_properties(&mut self, id: BodyId, from: BodyId) {
        let other = &self.bodies[from];
        let docs = other.docs.clone();
        let (version, lang, email) =
            (other.version.clone(), other.lang.clone(), other.email.clone());
        let (clock_rate, stack, real_time) = (other.clock_rate, other.stack, other.real_time);
        let (requires, codels) = (other.requires.clone(), other.codels_requires.clone());
        let throws = other.throws.clone();
        let body = &mut self.bodies[id];
        add_new(&mut body.docs, docs);
        add_throws(&mut body.throws, &throws);
        add_new(&mut body.requires, requires);
        add_new(&mut body.codels_requires, codels);
        let clashes = [
            merge_given(&mut body.version, version, "version"),
            merge_given(&mut body.lang, lang, "lang"),
            merge_given(&mut body.email, email, "email"),
            merge_given(&mut body.clock_rate, clock_rate, "clock-rate"),
            merge_given(&mut body.stack, stack, "stack"),
            merge_given(&mut body.real_time, real_time, "scheduling"),
        ];
        self.diagnostics.extend(clashes.into_iter().flatten());
    }

    fn merge_ids(&mut self, id: BodyId, from: BodyId) {
        let Some(ids) = self.bodies[from].ids else { return };
        let span = self.facts(ids).span.unwrap_or(self.bodies[from].span);
        self.open_ids(id, None, span);
        let scope = self.bodies[id].ids_scope;
        let members = self.types.members(ids).to_vec();
        for (member, span) in members.into_iter().zip(self.bodies[from].ids_members.clone()) {
            let name = Name { text: member.name.as_str().into(), span };
            // I7.
            if self.declare_in(scope, &name, Entity::Member, "E0407") {
                self.add_ids_member(id, member, span);
            }
        }
    }

    fn merge_task(&mut self, id: BodyId, task: Task) {
        let Task { name, span, docs, period, delay, priority, stack, real_time, throws, codels } =
            task;
        let mut known = match self.bodies[id].tasks.get(&name) {
            Some(known) => known.clone(),
            None => Task::new(name.clone(), span),
        };
        add_new(&mut known.docs, docs);
        let clashes = [
            merge_given(&mut known.period, period, "period"),
            merge_given(&mut known.delay, delay, "delay"),
            merge_given(&mut known.priority, priority, "priority"),
            merge_given(&mut known.stack, stack, "stack"),
            merge_given(&mut known.real_time, real_time, "scheduling"),
        ];
        self.diagnostics.extend(clashes.into_iter().flatten());
        add_throws(&mut known.throws, &throws);
        self.merge_codels(id, None, &codels, &mut known.codels);
        let (rank, _) = self.bodies[id].tasks.insert_full(name, known);
        self.bodies[id].touched_tasks.insert(rank);
    }

    /// Resolves codels of an interface anew in `id`.
    fn merge_codels(
        &mut self,
        id: BodyId,
        service: Option<&Service>,
        codels: &[CodelState],
        known: &mut Vec<CodelState>,
    ) {
        for codel in codels {
            if self.is_new_codel(&codel.syntax, known.iter())
                && let Some(state) =
                    self.codel(id, service, &codel.syntax, codel.role, Some(&codel.parameters))
            {
                known.push(state);
            }
        }
    }

    fn merge_port(&mut self, id: BodyId, name: &str, port: PortState, flip: bool) {
        let name = Name { text: name.into(), span: port.span };
        if !self.is_service_free(id, &name, "port") {
            return;
        }
        let out = port.out != flip;
        let interface = port.interface.filter(|_| !flip);
        self.add_port(id, &name, PortState { out, interface, ..port });
    }

    fn add_remote(&mut self, id: BodyId, name: &Name, remote: Remote) {
        if !self.is_service_free(id, name, "remote") {
            return;
        }
        let scope = self.bodies[id].scope;
        if self.declare_in(scope, name, Entity::Remote, "E0201") {
            self.bodies[id].remotes.insert(name.text.clone(), remote);
        }
    }

    fn merge_service(&mut self, id: BodyId, from: Service) {
        let name = Name { text: from.name.clone(), span: from.span };
        let Some(known) = self.start_service(id, from.kind, &name) else { return };
        let parameters = self.merge_parameters(id, &from.parameters);
        let mut service = match known {
            Some(mut known) => {
                if !self.same_parameters(&mut known, &parameters, from.span) {
                    known.broken = true;
                    self.bodies[id].services.insert(known.name.clone(), known);
                    return;
                }
                known
            }
            None => {
                let mut fresh = Service::new(from.kind, &name);
                fresh.standard = from.standard;
                fresh.parameters = parameters;
                fresh
            }
        };
        service.broken |= from.broken;
        add_new(&mut service.docs, from.docs);
        add_throws(&mut service.throws, &from.throws);
        for name in from.interrupts {
            if !service.interrupts.iter().any(|known| known.text == name.text) {
                service.interrupts.push(name);
            }
        }
        let clashes = [
            merge_given(&mut service.before, from.before, "before"),
            merge_given(&mut service.after, from.after, "after"),
        ];
        self.diagnostics.extend(clashes.into_iter().flatten());
        for local in from.locals {
            if !service.locals.iter().any(|known| known.name == local.name) {
                service.locals.push(local);
            }
        }
        // The tasks of the interface are already in `id` (step 2 of 4.6).
        if let Some((task, span)) = from.task {
            let clash = merge_given(&mut service.task, Some((task, span)), "task");
            self.diagnostics.extend(clash);
        }
        let mut validates = std::mem::take(&mut service.validates);
        self.merge_codels(id, Some(&service), &from.validates, &mut validates);
        service.validates = validates;
        let mut codels = std::mem::take(&mut service.codels);
        self.merge_codels(id, Some(&service), &from.codels, &mut codels);
        service.codels = codels;
        let (rank, _) = self.bodies[id].services.insert_full(name.text, service);
        self.bodies[id].touched_services.insert(rank);
    }

    /// Adjusts the parameters of an attribute to the IDS members of `id`.
    fn merge_parameters(&mut self, id: BodyId, from: &[Parameter]) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        for parameter in from {
            let mut parameter = parameter.clone();
            if let Some(target) = &parameter.target {
                let variable = target.variable.clone();
                let found = self.ids_path(id, variable.as_ref(), parameter.span);
                let Some((path, ty)) = found else { continue };
                parameter.ty = ty;
                parameter.target = Some(Target { path, variable });
            }
            parameters.push(parameter);
        }
        parameters
    }
}

/// Takes over the value of the merged body if there is none yet; two values are an error.
fn merge_given<T>(known: &mut Given<T>, fresh: Given<T>, what: &str) -> Option<Diagnostic> {
    match (&known, fresh) {
        (_, None) => None,
        (None, fresh) => {
            *known = fresh;
            None
        }
        (Some((_, first)), Some((_, span))) => Some(
            Diagnostic::error("E0405", span, format!("`{what}` is already given"))
                .note(*first, "given here"),
        ),
    }
}
