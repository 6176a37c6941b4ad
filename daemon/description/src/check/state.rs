//! Components and interfaces while they are read, before the model is made.

use std::collections::HashSet;
use std::rc::Rc;

use genom_types::TypeId;
use indexmap::{IndexMap, IndexSet};

use super::scope::ScopeId;
use crate::model::{
    Default as DefaultValue, Dialect, Direction, PathStep, PortIx, RemoteIx, Source, Span, StateIx,
    Yield,
};
use crate::syntax::{Codel, Name, Qualifier, ServiceKind, Variable};

/// Index of a body.
pub(super) type BodyId = usize;

/// A value and the position where it was given, to report a second one.
pub(super) type Given<T> = Option<(T, Span)>;

/// A component or an interface.
#[derive(Debug)]
pub(super) struct Body {
    pub(super) interface: bool,
    pub(super) name: Rc<str>,
    pub(super) span: Span,
    pub(super) scope: ScopeId,
    pub(super) dialect: Dialect,
    pub(super) docs: Vec<String>,
    pub(super) version: Given<String>,
    pub(super) lang: Given<String>,
    pub(super) email: Given<String>,
    pub(super) requires: Vec<String>,
    pub(super) codels_requires: Vec<String>,
    pub(super) clock_rate: Given<f64>,
    pub(super) stack: Given<u64>,
    pub(super) real_time: Given<()>,
    pub(super) throws: IndexSet<TypeId>,
    pub(super) ids: Option<TypeId>,
    pub(super) ids_scope: ScopeId,
    /// Where each member of the IDS is declared.
    pub(super) ids_members: Vec<Span>,
    pub(super) tasks: IndexMap<Rc<str>, Task>,
    pub(super) ports: IndexMap<Rc<str>, PortState>,
    pub(super) remotes: IndexMap<Rc<str>, Remote>,
    pub(super) services: IndexMap<Rc<str>, Service>,
    pub(super) states: IndexMap<Rc<str>, Span>,
    /// External events: states by rank, and where they are declared.
    pub(super) sinks: IndexMap<StateIx, Span>,
    /// Tasks and services that changed since the body was last closed.
    pub(super) touched_tasks: HashSet<usize>,
    pub(super) touched_services: HashSet<usize>,
}

#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) name: Rc<str>,
    pub(super) span: Span,
    pub(super) docs: Vec<String>,
    pub(super) period: Given<f64>,
    pub(super) delay: Given<f64>,
    pub(super) priority: Given<u32>,
    pub(super) stack: Given<u64>,
    pub(super) real_time: Given<()>,
    pub(super) throws: IndexSet<TypeId>,
    pub(super) codels: Vec<CodelState>,
}

impl Task {
    /// A task of which nothing is said yet.
    pub(super) fn new(name: Rc<str>, span: Span) -> Self {
        Self {
            name,
            span,
            docs: Vec::new(),
            period: None,
            delay: None,
            priority: None,
            stack: None,
            real_time: None,
            throws: IndexSet::new(),
            codels: Vec::new(),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct PortState {
    pub(super) out: bool,
    pub(super) multiple: bool,
    /// The interface that it comes from, if it was taken over unchanged.
    pub(super) interface: Option<Rc<str>>,
    pub(super) ty: TypeId,
    pub(super) docs: Vec<String>,
    pub(super) span: Span,
}

#[derive(Clone, Debug)]
pub(super) struct Remote {
    pub(super) interface: BodyId,
    /// Index of the service in that interface.
    pub(super) service: usize,
    pub(super) span: Span,
}

/// A service as declared, and extended when reopened, so far.
#[derive(Clone, Debug)]
pub(super) struct Service {
    pub(super) kind: ServiceKind,
    pub(super) name: Rc<str>,
    pub(super) span: Span,
    pub(super) docs: Vec<String>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) locals: Vec<Parameter>,
    pub(super) task: Given<usize>,
    pub(super) interrupts: Vec<Name>,
    pub(super) before: Given<Vec<Name>>,
    pub(super) after: Given<Vec<Name>>,
    pub(super) validates: Vec<CodelState>,
    pub(super) codels: Vec<CodelState>,
    pub(super) throws: IndexSet<TypeId>,
    pub(super) standard: bool,
    pub(super) through_ids: bool,
    /// A part of it was refused: errors that follow from that are not reported.
    pub(super) broken: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub(super) name: Rc<str>,
    pub(super) direction: Direction,
    pub(super) ty: TypeId,
    pub(super) default: Option<DefaultValue>,
    pub(super) target: Option<Target>,
    pub(super) span: Span,
}

/// The IDS member of an attribute's parameter.
#[derive(Clone, Debug)]
pub(super) struct Target {
    pub(super) path: Vec<PathStep>,
    /// As written, to be resolved anew in a component that provides the interface.
    pub(super) variable: Option<Variable>,
}

/// How the owner uses a codel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Validate,
    Simple,
    Machine,
}

/// A codel with its parameters resolved in its body.
#[derive(Clone, Debug)]
pub(super) struct CodelState {
    pub(super) syntax: Rc<Codel>,
    pub(super) role: Role,
    pub(super) parameters: Vec<CodelParameter>,
    pub(super) triggers: Vec<StateIx>,
    pub(super) yields: Vec<Yield>,
    pub(super) wcet: Option<f64>,
}

#[derive(Clone, Debug)]
pub(super) struct CodelParameter {
    pub(super) name: Rc<str>,
    pub(super) direction: Direction,
    pub(super) ty: TypeId,
    pub(super) source: Source,
    /// The resolved source, kept when the codel is resolved anew in another body.
    pub(super) qualifier: Qualifier,
    pub(super) span: Span,
}

/// What the first use of a codel fixes for all others (K1).
#[derive(Debug)]
pub(super) struct Prototype {
    pub(super) owner: BodyId,
    pub(super) parameters: Vec<(Direction, Argument)>,
    pub(super) span: Span,
}

/// What a codel is passed for a parameter.
#[derive(Clone, Debug)]
pub(super) enum Argument {
    Value(TypeId),
    Ids(TypeId),
    Port(PortIx, TypeId),
    Remote(RemoteIx),
}

impl Service {
    /// A service of which only kind and name are known.
    pub(super) fn new(kind: ServiceKind, name: &Name) -> Self {
        Self {
            kind,
            name: name.text.clone(),
            span: name.span,
            docs: Vec::new(),
            parameters: Vec::new(),
            locals: Vec::new(),
            task: None,
            interrupts: Vec::new(),
            before: None,
            after: None,
            validates: Vec::new(),
            codels: Vec::new(),
            throws: IndexSet::new(),
            standard: false,
            through_ids: false,
            broken: false,
        }
    }
}

/// Adds exceptions to a list, without repetitions.
pub(super) fn add_throws(known: &mut IndexSet<TypeId>, fresh: &IndexSet<TypeId>) {
    known.extend(fresh);
}

/// Adds packages, or lines of documentation, without repetitions. An interface may be merged twice
/// by two paths; its lines would otherwise double at each level.
pub(super) fn add_new(known: &mut Vec<String>, fresh: Vec<String>) {
    let mut all: IndexSet<String> = std::mem::take(known).into_iter().collect();
    all.extend(fresh);
    *known = all.into_iter().collect();
}
