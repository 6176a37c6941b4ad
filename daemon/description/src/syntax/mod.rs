//! The tree of a description as written: spans everywhere, nothing resolved.
//!
//! One tree serves the three generations of the language; what belongs to the papers only is
//! marked, and `check` decides what is allowed where.

mod body;
mod idl;
mod name;

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
    /// Identifiers of statements that could not be read: that they are unknown later is no news.
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
    /// What stands inside components in the current language, outside in the papers'.
    Outside(Export),
    /// A pragma that takes effect here.
    Pragma(Pragma, Span),
}
