//! The tree of a description as written: spans everywhere, nothing resolved.
//!
//! One tree serves the three generations of the language; what belongs to the papers only is
//! marked, and `check` decides what is allowed where.

mod body;
mod idl;

pub use body::{
    Body, Codel, CodelParameter, Direction, Event, Export, IdsDeclaration, Port, Property,
    PropertyKind, Qualifier, Quantity, Service, ServiceKind, ServiceParameter, ServiceParameters,
    Task, TimeUnit, Variable, VariableParameter, VariableStep, Wcet,
};
pub use idl::{
    Binary, Case, CaseLabel, Const, Constructed, Declarator, Enum, Exception, Expression,
    ExpressionKind, Idl, InitialStep, InitialValue, Initializer, Literal, Member, Struct, TypeSpec,
    TypeSpecKind, Typedef, Unary, Union,
};

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

/// An identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// As written.
    pub text: Rc<str>,
    /// Where.
    pub span: Span,
}

/// A name with its scopes, such as `::demo::state`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// Starts with `::`.
    pub absolute: bool,
    /// At least one.
    pub segments: Vec<Name>,
    /// The whole of it.
    pub span: Span,
}

impl std::fmt::Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (rank, segment) in self.segments.iter().enumerate() {
            if rank > 0 || self.absolute {
                f.write_str("::")?;
            }
            f.write_str(&segment.text)?;
        }
        Ok(())
    }
}

/// Adjacent string literals, joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// The text.
    pub text: String,
    /// All of the literals.
    pub span: Span,
}
