//! Tree to model: every name resolved into an index, every rule of genom3.md section 3 checked.
//!
//! One pass in the order of the text (declare before use), a few checks when a component closes,
//! the rest when all is read. A mistake is said once: what cannot be known because of it is
//! passed over in silence (see [`Checker::lost`]).

mod attribute;
mod body;
mod clock;
mod codel;
mod constant;
mod declare;
mod exclusion;
mod initial;
mod lower;
mod machine;
mod mapping;
mod merge;
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

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use genom_types::{ScopedName, TypeId, TypeTable};

use self::scope::{Entity, ScopeId, Scopes};
use self::state::{Body, BodyId};
use self::types::{Facts, Shape};
use self::value::Value;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Constant, Masquerade, Span, Specification};
use crate::syntax::{Path, Statement, Tree};
use crate::token::Pragma;

/// Errors that get a nearest name: finding it costs a look at all names.
const SUGGESTIONS: u32 = 50;

/// Checks a whole specification.
///
/// `standard` is the standard interface, declared before everything else. `root_of` gives the
/// input file through which a file is read: a component of the papers is one input file.
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

pub(super) struct Checker {
    types: TypeTable,
    facts: Vec<Facts>,
    shapes: HashMap<Shape, TypeId>,
    member_index: HashMap<TypeId, HashMap<String, usize>>,
    error_type: Option<TypeId>,
    scopes: Scopes,
    scope: ScopeId,
    constants: Vec<Constant>,
    /// Values of the constants, `None` when they could not be computed.
    constant_values: Vec<Option<Value>>,
    forwards: Vec<(TypeId, Span)>,
    masquerades: Vec<Masquerade>,
    bodies: Vec<Body>,
    body_index: HashMap<Rc<str>, BodyId>,
    /// Prototype of each codel, by name (K1).
    prototypes: HashMap<Rc<str>, codel::Prototype>,
    /// Names of all codels: most are new, and need not be compared with their neighbours.
    codel_names: HashSet<Rc<str>>,
    /// `#pragma requires` so far.
    requires: Vec<String>,
    /// `#pragma provides` so far.
    provided: Vec<(BodyId, Span)>,
    /// Names that a mistake kept from being declared: nothing more is said of them.
    lost: HashSet<Rc<str>>,
    suggestions: u32,
    taken: room::Taken,
    /// The statement being read: where what has no place of its own is said to be.
    place: Span,
    dialect: crate::model::Dialect,
    diagnostics: Diagnostics,
}

impl Checker {
    fn new(lost: HashSet<Rc<str>>) -> Self {
        Checker {
            types: TypeTable::default(),
            facts: Vec::new(),
            shapes: HashMap::new(),
            member_index: HashMap::new(),
            error_type: None,
            scopes: Scopes::new(),
            scope: 0,
            constants: Vec::new(),
            constant_values: Vec::new(),
            forwards: Vec::new(),
            masquerades: Vec::new(),
            bodies: Vec::new(),
            body_index: HashMap::new(),
            prototypes: HashMap::new(),
            codel_names: HashSet::new(),
            requires: Vec::new(),
            provided: Vec::new(),
            lost,
            suggestions: SUGGESTIONS,
            taken: room::Taken::default(),
            place: Span::default(),
            dialect: crate::model::Dialect::Current,
            diagnostics: Diagnostics::default(),
        }
    }

    fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    fn statement(&mut self, statement: Statement) {
        if self.taken.full {
            return;
        }
        match statement {
            Statement::Idl(idl) => self.idl(&idl),
            Statement::Component(body) => self.body(body, false),
            Statement::Interface(body) => self.body(body, true),
            Statement::Pragma(pragma, span) => self.pragma(&pragma, span),
            // `papers::gather` has put these into their component, or refused them.
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

    /// Full name of the service that a path names.
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
        // Ours: also a service, where the foreign type is one.
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
