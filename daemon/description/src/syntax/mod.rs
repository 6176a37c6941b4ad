//! The tree of a description as written: everything has a span, nothing is resolved.
//!
//! One tree serves the three generations of the language; what occurs only in the papers' dialects
//! is marked, and `check` decides what is allowed where.

mod body;
mod idl;
mod name;
pub mod words;

pub use body::{
    Body, Codel, CodelParameter, Direction, Event, Export, IdsDeclaration, PortDeclaration,
    Property, PropertyKind, Qualifier, Quantity, Service, ServiceKind, ServiceParameter,
    ServiceParameters, Task, TimeUnit, Variable, VariableParameter, VariableStep, Wcet,
};
pub use idl::{
    Binary, Case, CaseLabel, Const, Constructed, Declarator, Enum, Exception, Expression,
    ExpressionKind, Idl, InitialStep, InitialValue, Initializer, Literal, Member, Struct, TypeSpec,
    TypeSpecKind, Typedef, Unary, Union,
};
pub use name::{Name, Path, Text};

use std::collections::HashSet;
use std::rc::Rc;

use crate::model::Span;
use crate::token::Pragma;

/// All statements of all input files, in order.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Statements in order.
    pub statements: Vec<Statement>,
    /// Identifiers in statements that failed to parse: their use is not reported as unknown.
    pub lost: HashSet<Rc<str>>,
}

/// A statement at top level.
#[derive(Clone, Debug)]
pub enum Statement {
    /// Types, constants, modules.
    Idl(Idl),
    /// `component X {...};`
    Component(Body),
    /// `interface X {...};`
    Interface(Body),
    /// A statement that the papers' dialects have outside components.
    Outside(Export),
    /// A pragma that takes effect here.
    Pragma(Pragma, Span),
}
