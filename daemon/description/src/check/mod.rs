//! Tree to model: every name resolved into an index, every rule of genom3.md section 3 checked.
//!
//! One pass in the order of the text (declaration before use), some checks when a component closes,
//! the rest at the end. A mistake is reported once: errors that only follow from it are left out
//! (see [`Checker::lost`]).

mod attribute;
mod body;
mod checker;
mod clock;
mod codel;
mod constant;
mod declare;
mod exclusion;
mod facts;
mod initial;
mod lower;
mod machine;
mod mapping;
mod merge;
mod names;
mod papers;
mod pauses;
mod port;
mod property;
mod room;
mod scope;
mod service;
mod state;
mod task;
mod types;
mod value;
mod warnings;

use genom_types::ScopedName;

use self::checker::Checker;
use self::scope::Entity;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Masquerade, Span, Specification};
use crate::syntax::{Path, Statement, Tree};
use crate::token::Pragma;

/// Checks a whole specification.
///
/// `standard` is the tree of interface `genom`, declared before everything else. `root_of` maps a
/// file to the input file that includes it: in the papers' dialects a component is one input file.
pub(crate) fn check(
    tree: Tree,
    standard: Option<Tree>,
    root_of: &dyn Fn(u32) -> u32,
) -> (Specification, Diagnostics) {
    let mut checker = Checker::new(tree.lost);
    if let Some(standard) = standard {
        for statement in standard.statements {
            checker.statement(statement);
        }
    }
    let (statements, refused) = papers::gather(tree.statements, root_of);
    checker.diagnostics.append(refused);
    for (statement, dialect) in statements {
        checker.dialect = dialect;
        checker.statement(statement);
    }
    checker.finish()
}

impl Checker {
    fn statement(&mut self, statement: Statement) {
        if self.taken.full {
            return;
        }
        match statement {
            Statement::Idl(idl) => self.idl(&idl),
            Statement::Component(body) => self.body(body, false),
            Statement::Interface(body) => self.body(body, true),
            Statement::Pragma(pragma, span) => self.pragma(&pragma, span),
            // `papers::gather` has moved these into their component, or refused them.
            Statement::Outside(_) => {}
        }
    }

    // genom3.md 1.3.
    fn pragma(&mut self, pragma: &Pragma, span: Span) {
        match pragma {
            Pragma::Requires(packages) => {
                for (package, _) in packages {
                    if !self.requires.iter().any(|known| **known == **package) {
                        self.requires.push(package.to_string());
                    }
                }
            }
            Pragma::Provides(interfaces) => {
                for (name, span) in interfaces {
                    // I6.
                    if let Some(id) = self.interface(name, *span, "E0406") {
                        self.provided.push((id, *span));
                    }
                }
            }
            Pragma::Masquerade(arguments) => self.masquerade(arguments, span),
        }
    }

    /// Full name of the service that a path refers to.
    fn service_at(&self, path: &Path) -> Option<ScopedName> {
        let [component, service] = &path.segments[..] else { return None };
        let body = self.bodies.get(*self.body_index.get(&*component.text)?)?;
        let known = body.services.contains_key(&*service.text) && !body.interface;
        known.then(|| ScopedName::new([&*component.text, &*service.text]))
    }

    fn masquerade(&mut self, arguments: &[(Box<str>, Span)], span: Span) {
        let [(template, at), (ty, ty_span), (data, _)] = arguments else {
            let message = "`#pragma masquerade` takes a middleware, a type and a foreign type";
            self.push(
                Diagnostic::error("E0206", span, message)
                    .help("#pragma masquerade ros2 demo::pose geometry_msgs/msg/Pose"),
            );
            return;
        };
        let path = papers::path_of(ty, *ty_span);
        // An extension of genomd: the name may be that of a service, where the foreign type is one.
        let service = ["/srv/", "/action/"].iter().any(|folder| data.contains(folder));
        let (name, ty) = if service {
            let Some(name) = self.service_at(&path) else {
                let message = format!("there is no service `{ty}` so far");
                let error = Diagnostic::error("E0206", *ty_span, message)
                    .help("name component::service, below the component");
                return self.push(error);
            };
            (name, None)
        } else {
            let Some((Entity::Type(ty), _)) = self.find(&path, "type") else { return };
            (self.types.kind(ty).name().cloned().unwrap_or(ScopedName::new([&**data])), Some(ty))
        };
        let same = |m: &&Masquerade| *m.template == **template && m.ty == ty && m.name == name;
        if let Some(other) = self.masquerades.iter().find(same) {
            let what = if service { "service" } else { "type" };
            let message = format!("this {what} already has a masquerade");
            let error = Diagnostic::error("E0506", *at, message).note(other.span, "declared here");
            self.push(error);
            return;
        }
        self.masquerades.push(Masquerade {
            template: template.to_string(),
            name,
            ty,
            data: data.to_string(),
            span: *at,
        });
    }
}
