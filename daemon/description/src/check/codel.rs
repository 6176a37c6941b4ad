//! Codels: sources of their arguments, and what they yield (genom3.md 3.7, 4.4).

use std::collections::HashMap;
use std::rc::Rc;

use genom_types::TypeId;

use super::Checker;
use super::attribute::direction;
use super::facts::Shape;
use super::state::{Argument, Body, BodyId, CodelParameter, CodelState, Prototype, Role, Service};
use crate::diagnostic::Diagnostic;
use crate::model::{Dialect, Direction, Ix as _, PortIx, RemoteIx, Source, Span, StateIx, Yield};
use crate::syntax::{self, Codel, Name, Qualifier, Variable};

impl Checker {
    /// Reports a second codel with this name in one owner; true when there is none.
    // genom3.md 3.7 K2.
    pub(super) fn is_new_codel<'s>(
        &mut self,
        codel: &Codel,
        mut known: impl Iterator<Item = &'s CodelState>,
    ) -> bool {
        if !self.codel_names.contains(&codel.name.text) {
            return true;
        }
        let Some(other) = known.find(|other| other.syntax.name.text == codel.name.text) else {
            return true;
        };
        let message = format!("codel `{}` is already used here", codel.name.text);
        self.push(
            Diagnostic::error("E0702", codel.name.span, message)
                .note(other.syntax.name.span, "declared here"),
        );
        false
    }

    /// Resolves a codel in a body. `fixed` holds the sources that its parameters have in the
    /// interface it comes from.
    pub(super) fn codel(
        &mut self,
        id: BodyId,
        service: Option<&Service>,
        codel: &Rc<Codel>,
        role: Role,
        fixed: Option<&[CodelParameter]>,
    ) -> Option<CodelState> {
        if let Some(span) = codel.labels
            && self.bodies[id].dialect == Dialect::Current
        {
            let message = "states are written between `<` and `>`";
            self.push(
                Diagnostic::error("E0103", span, message)
                    .help(format!("write `codel<...> {}(...)`", codel.name.text)),
            );
        }
        self.codel_names.insert(codel.name.text.clone());
        let mut parameters: Vec<CodelParameter> = Vec::new();
        let mut seen: HashMap<Rc<str>, Span> = HashMap::new();
        for (rank, dcl) in codel.parameters.iter().enumerate() {
            let fixed = fixed.and_then(|list| list.get(rank)).map(|p| p.qualifier);
            let Some(parameter) = self.codel_parameter(id, service, codel, dcl, role, fixed) else {
                continue;
            };
            if let Some(first) = seen.insert(parameter.name.clone(), parameter.span) {
                self.duplicate_parameter(&parameter.name, parameter.span, first);
                continue;
            }
            parameters.push(parameter);
        }
        if parameters.len() == codel.parameters.len() && fixed.is_none() {
            self.check_prototype(id, codel, &parameters);
        }
        let (triggers, yields) = match &codel.machine {
            Some((triggers, yields)) => (self.triggers(id, triggers), self.yields(id, yields)),
            None => (Vec::new(), Vec::new()),
        };
        let wcet = codel.wcet.as_ref().and_then(|wcet| self.seconds(wcet, "wcet"));
        Some(CodelState { syntax: Rc::clone(codel), role, parameters, triggers, yields, wcet })
    }

    // genom3.md 3.7 K3, K4.
    fn triggers(&mut self, id: BodyId, events: &[syntax::Event]) -> Vec<StateIx> {
        let mut states: Vec<StateIx> = Vec::new();
        for event in events {
            let name = &event.name;
            if event.pause {
                let message = format!("`pause::{}` can be yielded, it triggers nothing", name.text);
                self.push(
                    Diagnostic::error("E0704", name.span, message)
                        .help(format!("write `{}`", name.text)),
                );
                continue;
            }
            if &*name.text == "sleep" && self.bodies[id].dialect != Dialect::Current {
                let message = "`sleep` is reserved, it triggers nothing";
                self.push(Diagnostic::error("E0704", name.span, message));
                continue;
            }
            let Some(state) = self.state(id, name) else { continue };
            if states.contains(&state) {
                self.duplicate_event(name);
                continue;
            }
            states.push(state);
        }
        states
    }

    // genom3.md 3.7 K3, K5.
    fn yields(&mut self, id: BodyId, events: &[syntax::Event]) -> Vec<Yield> {
        let mut yields: Vec<Yield> = Vec::new();
        for event in events {
            let name = &event.name;
            if event.pause && &*name.text == "ether" {
                let message = "`ether` is the end, there is no pause before it";
                self.push(Diagnostic::error("E0705", name.span, message).help("write `ether`"));
                continue;
            }
            let Some(state) = self.state(id, name) else { continue };
            let one = Yield { state, pause: event.pause };
            if yields.contains(&one) {
                self.duplicate_event(name);
                continue;
            }
            yields.push(one);
        }
        yields
    }

    fn duplicate_event(&mut self, name: &syntax::Name) {
        let message = format!("state `{}` is listed twice", name.text);
        self.push(Diagnostic::error("E0703", name.span, message));
    }

    fn codel_parameter(
        &mut self,
        id: BodyId,
        service: Option<&Service>,
        codel: &Codel,
        dcl: &syntax::CodelParameter,
        role: Role,
        fixed: Option<Qualifier>,
    ) -> Option<CodelParameter> {
        let name = match (&dcl.rename, &dcl.variable) {
            (Some(name), _) => name,
            (None, Some(variable)) => variable.last(),
            (None, None) => return None,
        };
        if dcl.paper && self.bodies[id].dialect == Dialect::Current {
            let message = "`inport` and `outport` belong to the papers' syntax";
            self.push(
                Diagnostic::error("E0103", dcl.span, message)
                    .help(format!("write `port in {0}` or `port out {0}`", name.text)),
            );
        }
        let qualifier = match fixed.or(dcl.qualifier) {
            Some(qualifier) => qualifier,
            None => self.implicit_source(id, service, dcl, role)?,
        };
        let variable = match (&dcl.variable, qualifier) {
            (Some(variable), _) => Some(variable),
            (None, Qualifier::Ids) => None,
            // K19.
            (None, _) => {
                let message = format!("parameter `{}` has no name of its own", name.text);
                self.push(
                    Diagnostic::error("E0719", dcl.span, message)
                        .help("`::name` alone is the whole IDS"),
                );
                return None;
            }
        };
        let direction = direction(dcl.direction);
        let mut name = name.text.clone();
        let (source, ty) = match (qualifier, variable) {
            (Qualifier::Ids, variable) => {
                let (path, ty) = self.ids_path(id, variable, dcl.span)?;
                (Source::Ids { path }, ty)
            }
            (Qualifier::Local, Some(variable)) => self.local_source(service, variable)?,
            (Qualifier::Port, Some(variable)) => {
                let (port, ty) = self.port_source(id, codel, variable, direction, role)?;
                // dialects.md, C signatures: a port and an IDS member may have the same name.
                if dcl.paper && dcl.rename.is_none() && self.ids_names(id).contains(&&*name) {
                    name = format!("{name}_port").into();
                }
                (Source::Port(port), ty)
            }
            (Qualifier::Remote, Some(variable)) => {
                let remote = self.remote_source(id, codel, variable, direction, role)?;
                // Replaced by the input record when the model is made.
                (
                    Source::Remote(remote),
                    self.shared(Shape::Basic("long"), || genom_types::Kind::Long),
                )
            }
            (_, None) => return None,
        };
        Some(CodelParameter { name, direction, ty, source, qualifier, span: dcl.span })
    }

    /// The source of a parameter without qualifier.
    // genom3.md 4.4, 3.7 K12, K13.
    fn implicit_source(
        &mut self,
        id: BodyId,
        service: Option<&Service>,
        dcl: &syntax::CodelParameter,
        role: Role,
    ) -> Option<Qualifier> {
        let Some(variable) = &dcl.variable else { return Some(Qualifier::Ids) };
        let name = &variable.root;
        let local = service.and_then(|service| {
            service.parameters.iter().chain(&service.locals).find(|p| p.name == name.text)
        });
        let body = &self.bodies[id];
        if body.dialect != Dialect::Current {
            // dialects.md: `in x` is the IDS member; validate sees the new value.
            let new_value = role == Role::Validate && local.is_some();
            return Some(if new_value { Qualifier::Local } else { Qualifier::Ids });
        }
        let ids = body.ids;
        let ids = ids.and_then(|ids| self.member(ids, &name.text));
        let body = &self.bodies[id];
        let mut found = Vec::new();
        if let Some((rank, _)) = ids {
            let span = body.ids_members.get(rank).copied();
            found.push((Qualifier::Ids, "ids", span.unwrap_or(body.span)));
        }
        if let Some(parameter) = local {
            found.push((Qualifier::Local, "local", parameter.span));
        }
        if let Some(port) = body.ports.get(&name.text) {
            found.push((Qualifier::Port, "port", port.span));
        }
        if let Some(remote) = body.remotes.get(&name.text) {
            found.push((Qualifier::Remote, "remote", remote.span));
        }
        match &*found {
            [(qualifier, ..)] => Some(*qualifier),
            [] => {
                if !self.lost.contains(&name.text) {
                    let help = self.suggest(&name.text, |this| {
                        let body = &this.bodies[id];
                        let mut names = this.ids_names(id);
                        names.extend(body.ports.keys().map(|name| &**name));
                        names.extend(body.remotes.keys().map(|name| &**name));
                        names
                    });
                    let near = service.and_then(|service| near_parameter(service, &name.text));
                    let message = format!("unknown source for parameter `{}`", name.text);
                    let mut error = Diagnostic::error("E0712", name.span, message);
                    error.help = near.or(help);
                    self.push(error);
                }
                None
            }
            several => {
                let words: Vec<_> =
                    several.iter().map(|(_, word, _)| format!("`{word}`")).collect();
                let message = format!("parameter `{}` may come from several places", name.text);
                let mut error = Diagnostic::error("E0713", dcl.span, message)
                    .help(format!("write {} before it", words.join(" or ")));
                for (_, word, span) in several {
                    error = error.note(*span, format!("{word} {}", name.text));
                }
                self.push(error);
                None
            }
        }
    }

    // genom3.md 3.7 K18.
    fn local_source(
        &mut self,
        service: Option<&Service>,
        variable: &Variable,
    ) -> Option<(Source, TypeId)> {
        let name = &variable.root;
        let found = service.and_then(|service| {
            let all = service.parameters.iter().chain(&service.locals);
            all.enumerate()
                .find(|(_, p)| p.name == name.text)
                .map(|(rank, p)| (rank, p.ty, service.parameters.len()))
        });
        let Some((rank, ty, count)) = found else {
            if !self.lost.contains(&name.text) {
                let message = format!("no such service parameter `{}`", name.text);
                let mut error = Diagnostic::error("E0718", name.span, message);
                error.help = service.and_then(|service| near_parameter(service, &name.text));
                self.push(error);
            }
            return None;
        };
        let mut path = Vec::new();
        let ty = self.walk(ty, &variable.steps, &mut path)?;
        Some(match rank.checked_sub(count) {
            None => (Source::Parameter { index: rank, path }, ty),
            Some(index) => (Source::Local { index, path }, ty),
        })
    }

    // genom3.md 3.7 K20 to K22, 3.6 S11.
    fn port_source(
        &mut self,
        id: BodyId,
        codel: &Codel,
        variable: &Variable,
        direction: Direction,
        role: Role,
    ) -> Option<(PortIx, TypeId)> {
        let name = &variable.root;
        let Some((rank, _, port)) = self.bodies[id].ports.get_full(&name.text) else {
            self.unknown(id, "port", name, |body| body.ports.keys().map(|name| &**name).collect());
            return None;
        };
        let (out, ty, span) = (port.out, port.ty, port.span);
        self.refuse_in_control(codel, "port", name, role);
        if !out && direction == Direction::Out {
            let message = format!("port `{}` is read-only", name.text);
            self.push(Diagnostic::error("E0721", name.span, message).note(span, "declared here"));
        }
        if !variable.steps.is_empty() {
            let message =
                format!("members of port `{}` cannot be passed, only the port", name.text);
            self.push(Diagnostic::error("E0722", name.span, message).note(span, "declared here"));
        }
        Some((PortIx::new(rank), ty))
    }

    /// Reports a port or remote that the component lacks.
    fn unknown(
        &mut self,
        id: BodyId,
        what: &str,
        name: &Name,
        known: impl FnOnce(&Body) -> Vec<&str>,
    ) {
        if !self.lost.contains(&name.text) {
            let help = self.suggest(&name.text, |this| known(&this.bodies[id]));
            let message = format!("unknown {what} `{}`", name.text);
            let mut error = Diagnostic::error("E0720", name.span, message);
            error.help = help;
            self.push(error);
        }
    }

    // genom3.md 3.7 K20, K22, K23.
    fn remote_source(
        &mut self,
        id: BodyId,
        codel: &Codel,
        variable: &Variable,
        direction: Direction,
        role: Role,
    ) -> Option<RemoteIx> {
        let name = &variable.root;
        let Some((rank, _, remote)) = self.bodies[id].remotes.get_full(&name.text) else {
            self.unknown(id, "remote", name, |body| {
                body.remotes.keys().map(|name| &**name).collect()
            });
            return None;
        };
        let span = remote.span;
        self.refuse_in_control(codel, "remote", name, role);
        if direction != Direction::In {
            let message = format!("remote `{}` can only be `in`", name.text);
            self.push(Diagnostic::error("E0723", name.span, message).note(span, "declared here"));
        }
        if !variable.steps.is_empty() {
            let message = format!("remote `{}` has no members", name.text);
            self.push(Diagnostic::error("E0722", name.span, message).note(span, "declared here"));
        }
        Some(RemoteIx::new(rank))
    }

    // genom3.md 3.6 S11.
    fn refuse_in_control(&mut self, codel: &Codel, what: &str, name: &syntax::Name, role: Role) {
        let kind = match role {
            Role::Machine => return,
            Role::Validate => "validate",
            Role::Simple => "simple",
        };
        let message =
            format!("{what} `{}` is not allowed in {kind} codel `{}`", name.text, codel.name.text);
        self.push(
            Diagnostic::error("E0611", name.span, message)
                .help("only codels with states use ports and remotes"),
        );
    }

    // genom3.md 3.7 K1.
    fn check_prototype(&mut self, id: BodyId, codel: &Codel, parameters: &[CodelParameter]) {
        let fresh: Vec<(Direction, Argument)> = parameters
            .iter()
            .map(|p| {
                let argument = match &p.source {
                    Source::Ids { path } if path.is_empty() => Argument::Ids(p.ty),
                    Source::Port(port) => Argument::Port(*port, p.ty),
                    Source::Remote(remote) => Argument::Remote(*remote),
                    _ => Argument::Value(p.ty),
                };
                (p.direction, argument)
            })
            .collect();
        let Some(known) = self.prototypes.get(&codel.name.text) else {
            let prototype = Prototype { owner: id, parameters: fresh, span: codel.name.span };
            self.prototypes.insert(codel.name.text.clone(), prototype);
            return;
        };
        let same_owner = known.owner == id;
        let equal = |a: TypeId, b: TypeId| a == b || self.types.equal(a, b);
        let same = known.parameters.len() == fresh.len()
            && known.parameters.iter().zip(&fresh).all(|((d, a), (e, b))| {
                d == e
                    && match (a, b) {
                        (Argument::Value(a), Argument::Value(b)) => equal(*a, *b),
                        // The IDS, ports and remotes of another component have other C types,
                        // but also another header.
                        (Argument::Ids(a), Argument::Ids(b)) => !same_owner || a == b,
                        (Argument::Port(p, a), Argument::Port(q, b)) => {
                            if same_owner {
                                p == q
                            } else {
                                equal(*a, *b)
                            }
                        }
                        (Argument::Remote(a), Argument::Remote(b)) => !same_owner || a == b,
                        _ => false,
                    }
            });
        if !same {
            let span = known.span;
            let message = format!("codel `{}` has other parameters elsewhere", codel.name.text);
            self.push(
                Diagnostic::error("E0701", codel.name.span, message)
                    .note(span, "first used here")
                    .help("a codel is one C function: directions and types must be the same"),
            );
        }
    }
}

/// Help with the nearest of the parameters and locals of a service.
fn near_parameter(service: &Service, name: &str) -> Option<String> {
    let all = service.parameters.iter().chain(&service.locals);
    genom_nearest::meant(name, all.map(|p| &*p.name))
}
