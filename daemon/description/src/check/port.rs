//! Ports.

use genom_types::Kind;

use super::Checker;
use super::scope::Entity;
use super::state::{BodyId, PortState};
use crate::diagnostic::Diagnostic;
use crate::model::Dialect;
use crate::syntax::{self, PropertyKind};

impl Checker {
    // genom3.md 3.6 S2, S18 to S20; 3.5 P4.
    pub(super) fn port(&mut self, id: BodyId, dcl: &syntax::PortDeclaration) {
        if dcl.paper && self.bodies[id].dialect == Dialect::Current {
            let word = if dcl.out { "outport" } else { "inport" };
            let message = format!("`{word}` belongs to the papers' syntax");
            let way = if dcl.out { "out" } else { "in" };
            self.push(
                Diagnostic::error("E0103", dcl.span, message)
                    .help(format!("write `port {way} TYPE {};`", dcl.name.text)),
            );
        }
        let mut docs = Vec::new();
        for property in &dcl.properties {
            self.check_colon(id, property);
            let keyword = &property.keyword;
            match &property.kind {
                PropertyKind::Doc(text) => docs.push(text.text.clone()),
                PropertyKind::Local(..) => {
                    let message = "local variables belong to functions and activities";
                    self.push(Diagnostic::error("E0616", keyword.span, message));
                }
                _ => {
                    let message = format!("`{}` is no property of ports", keyword.text);
                    self.push(Diagnostic::error("E0504", keyword.span, message));
                }
            }
        }
        let name = &dcl.name;
        let Some(ty) = self.type_spec(&dcl.ty) else {
            self.lost.insert(name.text.clone());
            return;
        };
        let anonymous = self.types.kind(ty).name().is_none() && !self.is_error(ty);
        // dialects.md A: basic types are allowed in the papers.
        if anonymous && self.bodies[id].dialect == Dialect::Current {
            let message = format!("port `{}` needs a type with a name", name.text);
            let spelt = self.type_name(ty);
            self.push(
                Diagnostic::error("E0618", dcl.ty.span, message)
                    .help(format!("declare `typedef {spelt} NAME;` and use NAME")),
            );
            self.lost.insert(name.text.clone());
            return;
        }
        if self.contains_native(ty) {
            let message = format!("port `{}` cannot hold a native type", name.text);
            self.push(Diagnostic::error("E0619", dcl.ty.span, message));
            self.lost.insert(name.text.clone());
            return;
        }
        if !self.is_service_free(id, name, "port") {
            return;
        }
        if matches!(self.types.kind(ty), Kind::Forward { .. }) {
            return;
        }
        let interface = self.bodies[id].interface.then(|| self.bodies[id].name.clone());
        let (out, multiple, span) = (dcl.out, dcl.multiple, name.span);
        let port = PortState { out, multiple, interface, ty, docs, span };
        self.add_port(id, name, port);
    }

    pub(super) fn add_port(&mut self, id: BodyId, name: &syntax::Name, port: PortState) -> bool {
        let scope = self.bodies[id].scope;
        let made = self.declare_in(scope, name, Entity::Port, "E0620");
        if made {
            self.bodies[id].ports.insert(name.text.clone(), port);
        }
        made
    }

    /// Reports a service with this name; true when there is none.
    pub(super) fn is_service_free(&mut self, id: BodyId, name: &syntax::Name, what: &str) -> bool {
        let Some(service) = self.bodies[id].services.get(&name.text) else { return true };
        let message = format!("`{}` is a service, it cannot be a {what} too", name.text);
        let span = service.span;
        self.push(Diagnostic::error("E0602", name.span, message).note(span, "declared here"));
        false
    }
}
