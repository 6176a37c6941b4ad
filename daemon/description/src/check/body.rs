//! Opening and closing of components and interfaces.

use std::collections::HashSet;

use genom_types::{Kind, Member};
use indexmap::{IndexMap, IndexSet};

use super::Checker;
use super::room;
use super::scope::{Entity, ScopeKind};
use super::state::{Body, BodyId};
use crate::diagnostic::Diagnostic;
use crate::model::{Dialect, Ix as _, Span, StateIx};
use crate::syntax::{self, Export, IdsDeclaration, Name};

impl Checker {
    /// Each part of the tree is dropped as soon as it is checked, to save memory.
    pub(super) fn body(&mut self, dcl: syntax::Body, interface: bool) {
        let Some(id) = self.open_body(&dcl.name, interface) else { return };
        let outer = std::mem::replace(&mut self.scope, self.bodies[id].scope);
        self.place = dcl.name.span;
        for export in dcl.exports {
            if self.taken.full {
                break;
            }
            match export {
                Export::Idl(idl) => self.idl(&idl),
                Export::Property(property) => self.body_property(id, &property),
                Export::Ids(ids) => self.ids(id, &ids),
                Export::Task(task) => self.task(id, &task),
                Export::Port(port) => self.port(id, &port),
                Export::Service(service) => self.service(id, &service),
                Export::Events(names) => names.iter().for_each(|name| self.event_sink(id, name)),
                Export::Pragma(pragma, span) => self.pragma(&pragma, span),
            }
        }
        self.close_body(id);
        self.scope = outer;
    }

    fn open_body(&mut self, name: &Name, interface: bool) -> Option<BodyId> {
        let what = |interface| if interface { "an interface" } else { "a component" };
        if let Some(&id) = self.body_index.get(&name.text) {
            let known = &self.bodies[id];
            // I1.
            if known.interface != interface {
                let message = format!(
                    "`{}` is {}, it cannot be {} too",
                    name.text,
                    what(known.interface),
                    what(interface)
                );
                let span = known.span;
                self.push(
                    Diagnostic::error("E0401", name.span, message).note(span, "declared here"),
                );
                return None;
            }
            if known.dialect != Dialect::Current {
                let (span, message) = (known.span, "a component of the papers cannot be reopened");
                self.push(
                    Diagnostic::error("E0401", name.span, message).note(span, "declared here"),
                );
                return None;
            }
            return Some(id);
        }
        let requires: usize = self.requires.iter().map(|text| size_of_val(text) + text.len()).sum();
        if !self.reserve(room::BODY + requires, name.span) {
            return None;
        }
        let scope = self.open_module(name)?;
        let pause = Name { text: "pause".into(), span: name.span };
        if self.scopes.child(scope, "pause").is_none() {
            self.scopes.add_child(scope, &pause, ScopeKind::Module);
        }
        let id = self.bodies.len();
        self.bodies.push(Body {
            interface,
            name: name.text.clone(),
            span: name.span,
            scope,
            dialect: if interface { Dialect::Current } else { self.dialect },
            docs: Vec::new(),
            version: None,
            lang: None,
            email: None,
            requires: self.requires.clone(),
            codels_requires: Vec::new(),
            clock_rate: None,
            stack: None,
            real_time: None,
            throws: IndexSet::new(),
            ids: None,
            ids_scope: 0,
            ids_members: Vec::new(),
            tasks: IndexMap::new(),
            ports: IndexMap::new(),
            remotes: IndexMap::new(),
            services: IndexMap::new(),
            states: IndexMap::new(),
            sinks: IndexMap::new(),
            touched_tasks: HashSet::new(),
            touched_services: HashSet::new(),
        });
        self.body_index.insert(name.text.clone(), id);
        if !interface {
            let outer = std::mem::replace(&mut self.scope, scope);
            // genom3.md 4.2: a component starts with these.
            for state in ["ether", "start", "stop"] {
                self.state(id, &Name { text: state.into(), span: name.span });
            }
            for (provided, span) in self.provided.clone() {
                self.merge(id, provided, false, span);
            }
            self.scope = outer;
        }
        Some(id)
    }

    /// Index of the state with this name, added if new.
    // genom3.md 3.7 K6.
    pub(super) fn state(&mut self, id: BodyId, name: &Name) -> Option<StateIx> {
        if let Some(rank) = self.bodies[id].states.get_index_of(&name.text) {
            return Some(StateIx::new(rank));
        }
        let scope = self.bodies[id].scope;
        if !self.declare_in(scope, name, Entity::State, "E0706") {
            return None;
        }
        let (rank, _) = self.bodies[id].states.insert_full(name.text.clone(), name.span);
        Some(StateIx::new(rank))
    }

    // dialects.md A.
    fn event_sink(&mut self, id: BodyId, name: &Name) {
        if matches!(&*name.text, "ether" | "start" | "stop" | "sleep") {
            let message = format!("`{}` is a reserved state, no external event", name.text);
            self.push(Diagnostic::error("E0706", name.span, message));
            return;
        }
        let Some(state) = self.state(id, name) else { return };
        if let Some(other) = self.bodies[id].sinks.insert(state, name.span) {
            let message = format!("event `{}` is declared twice", name.text);
            self.push(Diagnostic::error("E0703", name.span, message).note(other, "first here"));
        }
    }

    fn ids(&mut self, id: BodyId, dcl: &IdsDeclaration) {
        let mut given = dcl.name.as_ref();
        if let Some(name) = given
            && self.bodies[id].dialect == Dialect::Current
        {
            let message = "the IDS of a component has no name of its own";
            self.push(Diagnostic::error("E0103", name.span, message).help("write `ids { ... };`"));
            given = None;
        }
        self.open_ids(id, given, dcl.span);
        let scope = self.bodies[id].ids_scope;
        let outer = std::mem::replace(&mut self.scope, scope);
        for member in &dcl.members {
            let ty = self.type_spec(&member.ty);
            for declarator in &member.declarators {
                let name = &declarator.name;
                match ty.and_then(|ty| self.declared(ty, declarator)) {
                    // I7.
                    Some(ty) if self.declare_in(scope, name, Entity::Member, "E0407") => {
                        let member = Member { name: name.text.to_string(), ty };
                        self.add_ids_member(id, member, name.span);
                    }
                    Some(_) => {}
                    None => _ = self.lost.insert(name.text.clone()),
                }
            }
        }
        self.scope = outer;
    }

    /// Adds an empty struct for the IDS, if there is none.
    pub(super) fn open_ids(&mut self, id: BodyId, name: Option<&Name>, span: Span) {
        if self.bodies[id].ids.is_some() {
            return;
        }
        // dialects.md B: `ids demo_state {...}` at top level; else `::component::ids`.
        let ids = Name { text: "ids".into(), span };
        let (outer, name) = match name {
            Some(name) => (0, name),
            None => (self.bodies[id].scope, &ids),
        };
        let kept = std::mem::replace(&mut self.scope, outer);
        let (scope, _) = self.open_record(name);
        let full = self.scopes.full_name(outer).join(&name.text);
        let ty = self.add_type(Kind::Struct { name: full, members: Vec::new() }, Some(span));
        self.declare(name, Entity::Type(ty));
        self.scope = kept;
        self.bodies[id].ids = Some(ty);
        self.bodies[id].ids_scope = scope;
    }

    pub(super) fn add_ids_member(&mut self, id: BodyId, member: Member, span: Span) {
        let Some(ids) = self.bodies[id].ids else { return };
        self.bodies[id].ids_members.push(span);
        self.grow_type(ids, member, span);
    }

    /// Finds an interface by name; reports code `unknown` if there is none.
    // genom3.md 3.4 I2, I3.
    pub(super) fn interface(
        &mut self,
        name: &str,
        span: Span,
        unknown: &'static str,
    ) -> Option<BodyId> {
        match self.body_index.get(name) {
            Some(&id) if self.bodies[id].interface => Some(id),
            Some(&id) => {
                let code = if unknown == "E0402" { "E0403" } else { unknown };
                let message = format!("`{name}` is a component, an interface is wanted");
                let place = self.bodies[id].span;
                self.push(Diagnostic::error(code, span, message).note(place, "declared here"));
                None
            }
            None => {
                if !self.lost.contains(name) {
                    let help = self.suggest(name, |this| {
                        let bodies = this.bodies.iter().filter(|body| body.interface);
                        bodies.map(|body| &*body.name).collect()
                    });
                    let mut error =
                        Diagnostic::error(unknown, span, format!("no such interface `{name}`"));
                    error.help = help;
                    self.push(error);
                }
                None
            }
        }
    }

    /// Checks that are made when a body closes (genom3.md 4.1).
    fn close_body(&mut self, id: BodyId) {
        let mut tasks: Vec<_> =
            std::mem::take(&mut self.bodies[id].touched_tasks).into_iter().collect();
        let mut services: Vec<_> =
            std::mem::take(&mut self.bodies[id].touched_services).into_iter().collect();
        tasks.sort_unstable();
        services.sort_unstable();
        if self.bodies[id].dialect == Dialect::Paper2011 {
            self.declare_sinks_by_use(id);
        }
        for &rank in &services {
            self.check_named_services(id, rank);
        }
        if self.bodies[id].interface {
            return;
        }
        for rank in tasks {
            self.check_task_machine(id, rank);
        }
        for rank in services {
            self.check_activity(id, rank);
        }
    }
}
