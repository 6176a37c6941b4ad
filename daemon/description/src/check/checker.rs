//! State of checking a tree.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use genom_types::{TypeId, TypeTable};

use super::facts::{Facts, Shape};
use super::scope::{ScopeId, Scopes};
use super::state::{Body, BodyId, Prototype};
use super::value::Value;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Constant, Dialect, Masquerade, Span};

/// Errors that get a suggestion: finding the nearest name compares all names.
const SUGGESTIONS: u32 = 50;

/// Makes a model from trees; each file of this folder adds the rules of one subject.
pub(super) struct Checker {
    pub(super) types: TypeTable,
    pub(super) facts: Vec<Facts>,
    pub(super) shapes: HashMap<Shape, TypeId>,
    pub(super) member_index: HashMap<TypeId, HashMap<String, usize>>,
    pub(super) error_type: Option<TypeId>,
    pub(super) scopes: Scopes,
    pub(super) scope: ScopeId,
    pub(super) constants: Vec<Constant>,
    /// Values of the constants; `None` for those that could not be computed.
    pub(super) constant_values: Vec<Option<Value>>,
    pub(super) forwards: Vec<(TypeId, Span)>,
    pub(super) masquerades: Vec<Masquerade>,
    pub(super) bodies: Vec<Body>,
    pub(super) body_index: HashMap<Rc<str>, BodyId>,
    /// First use of each codel name, which fixes its prototype (K1).
    pub(super) prototypes: HashMap<Rc<str>, Prototype>,
    /// Names of all codels so far: for a new one no duplicate has to be searched.
    pub(super) codel_names: HashSet<Rc<str>>,
    /// `#pragma requires` so far.
    pub(super) requires: Vec<String>,
    /// `#pragma provides` so far.
    pub(super) provided: Vec<(BodyId, Span)>,
    /// Names whose declaration was refused; their use is not reported again.
    pub(super) lost: HashSet<Rc<str>>,
    pub(super) suggestions: u32,
    pub(super) taken: Taken,
    /// Position of the statement being checked, for errors about items without a position of their
    /// own.
    pub(super) place: Span,
    pub(super) dialect: Dialect,
    pub(super) diagnostics: Diagnostics,
}

/// Memory counted so far, for the limit of `room`.
#[derive(Debug, Default)]
pub(super) struct Taken {
    pub(super) bytes: usize,
    /// The limit is reached: nothing more is made, and this was reported once.
    pub(super) full: bool,
}

impl Checker {
    pub(super) fn new(lost: HashSet<Rc<str>>) -> Self {
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
            taken: Taken::default(),
            place: Span::default(),
            dialect: Dialect::Current,
            diagnostics: Diagnostics::default(),
        }
    }

    /// Reports an error or warning.
    pub(super) fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }
}
